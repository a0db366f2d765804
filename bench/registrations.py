"""A thousand modules on one bus, each registered with central and given work by it.

    uv run python bench/registrations.py --modules 1000
    uv run python bench/registrations.py --modules 1000 --processes 10

The modules are stand-ins in one process that speak what `docs/wire.md` says and no more: each has
a Zenoh session, a token, introduces itself, and handles a command of its own. With ``--processes``
they are real ones, spread over so many processes, and each has to see all others; those of one
process share a Zenoh session, or with ``--session own`` do not. Prints the wall
seconds until a bystander sees all of them, until they see each other, until every one has carried
out its command, and the resident memory of central and the router before and after, in MB. What an
operating system's limit forbids is named at once.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import os
import queue
import resource
import signal
import socket
import sys
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from pathlib import Path
from typing import Any, Literal

import zenoh
from zenoh.handlers import Callback

from tca_bus import BusOptions, Command, Constraint, Module
from tca_bus._joining import client_config
from tca_bus._protocol import ModuleCard, Outcome, ProvidedMessage, ReportOutcome, Taken
from tca_bus.launcher import ModulePresent, RouterListening
from tca_bus.testing import eventually

PAGE = os.sysconf("SC_PAGE_SIZE")
PATIENCE = 300.0
AT_ONCE = 64
REALM = "many"


def command_of(number: int) -> type[Command[int]]:
    """The command that module ``number`` alone handles."""

    class Toil(Command[int]):
        wire_name = f"toil-{number}"

    return Toil


class StandIn:
    """A module as central sees it."""

    def __init__(self, number: int, options: BusOptions, work: queue.SimpleQueue) -> None:
        self.number = number
        self.name = f"module-{number}"
        self.incarnation = f"{time.time_ns() // 1_000_000:012x}{number:06x}"
        self.session = zenoh.open(client_config(options))
        queries = f"{REALM}/query/{self.name}/{self.incarnation}/**"
        answered = Callback(lambda query: work.put((self, query)), indirect=False)
        self.session.declare_queryable(queries, answered)
        key = f"{REALM}/presence/{self.name}/{self.incarnation}/here/{os.getpid()}/toil-{number}"
        self.token = self.session.liveliness().declare_token(key)

    def answer(self, query: zenoh.Query) -> None:
        """Introduce itself, or carry out a task at once."""
        with query:
            message = json.loads(query.payload.to_string()) if query.payload else {}
            if "/tca.handle/" not in str(query.key_expr):
                query.reply(query.key_expr, self.card().model_dump_json())
                return
            taken = Taken(id=message["id"], attempt=message["attempt"])
            query.reply(query.key_expr, taken.model_dump_json())
        self.report(taken)

    def report(self, taken: Taken) -> None:
        """Tell central that the task is done."""
        done = ReportOutcome(
            id=taken.id, attempt=taken.attempt, outcome=Outcome.SUCCESS, result=self.number
        )
        key = f"{REALM}/query/central/*/tca.report/{self.name}"
        self.session.get(
            key, Callback(lambda _: None, indirect=False), payload=done.model_dump_json()
        )

    def card(self) -> ModuleCard:
        """What it says of itself."""
        provided = ProvidedMessage(
            name=f"toil-{self.number}",
            message_class="command",
            revision=1,
            summary="",
            message_schema={},
            reply_schema=None,
        )
        return ModuleCard(
            name=self.name,
            incarnation=self.incarnation,
            pid=os.getpid(),
            host="here",
            version="0",
            started=time.time(),
            provides=[provided],
            dropped={},
            invalid=0,
            handling=[],
        )


def serve(endpoint: str, count: int) -> None:
    """Be all the modules, until killed."""
    options = BusOptions(connect=endpoint, realm=REALM)
    work: queue.SimpleQueue[tuple[StandIn, zenoh.Query]] = queue.SimpleQueue()
    crowd = [StandIn(number, options, work) for number in range(count)]
    while crowd:
        module, query = work.get()
        module.answer(query)


async def crowd(
    endpoint: str, session: Literal["own", "shared"], first: int, count: int, everybody: int
) -> None:
    """Be ``count`` real modules from number ``first`` on; say when each sees ``everybody``."""
    options = BusOptions(connect=endpoint, realm=REALM, connect_timeout=PATIENCE, session=session)
    async with contextlib.AsyncExitStack() as stack:
        modules = []
        for number in range(first, first + count):
            module = Module(f"module-{number}", options=options)
            module.serve(command_of(number), _answering(number))
            modules.append(await stack.enter_async_context(module))
        await eventually(
            lambda: all(len(module.modules()) == everybody for module in modules), timeout=PATIENCE
        )
        print(threads_here(), flush=True)
        await asyncio.get_running_loop().create_future()


def _answering(number: int) -> Callable[[Any, Any], Awaitable[int]]:
    async def toil(_message: Any, _context: Any) -> int:
        return number

    return toil


def threads_here() -> int:
    return len(list(Path("/proc/self/task").iterdir()))


def check_limits(modules: int, processes: int, session: str) -> None:
    """End with the name of the limit that forbids so many modules.

    A module with a session of its own takes a file and up to eight threads in its process, and a
    file in the router's.
    """
    files = modules + 200
    allowed = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    if allowed < files:
        sys.exit(f"the limit of open files, RLIMIT_NOFILE, is {allowed}; needed: {files}")
    own = 0 if processes and session == "shared" else modules
    threads, most = 8 * own + 20 * processes, resource.getrlimit(resource.RLIMIT_NPROC)[0]
    if resource.RLIM_INFINITY != most < threads:
        sys.exit(f"the limit of threads, RLIMIT_NPROC, is {most}; needed: {threads}")


@contextlib.asynccontextmanager
async def process(*arguments: str) -> AsyncIterator[int]:
    child = await asyncio.create_subprocess_exec(sys.executable, *arguments)
    try:
        yield child.pid
    finally:
        if child.returncode is None:
            child.send_signal(signal.SIGKILL)
        await child.wait()


def memory(pid: int) -> float:
    pages = int(Path(f"/proc/{pid}/statm").read_text(encoding="utf-8").split()[1])
    return pages * PAGE / 1e6


async def put_to_work(boss: Module, count: int) -> None:
    """Have every module carry out its command."""
    numbers = iter(range(count))

    async def one_after_the_other() -> None:
        for number in numbers:
            command = command_of(number)()
            handle = await boss.execute(
                command, constraints=Constraint.NONE, wait_for_handler=PATIENCE, timeout=PATIENCE
            )
            assert await handle.result(timeout=PATIENCE) == number

    async with asyncio.TaskGroup() as group:
        for _ in range(AT_ONCE):
            group.create_task(one_after_the_other())


async def start_crowds(
    stack: contextlib.AsyncExitStack, endpoint: str, count: int, processes: int, session: str
) -> list[asyncio.subprocess.Process]:
    """Start the processes of real modules; central and the boss are there too."""
    started = []
    for place in range(processes):
        first, after = (count * bound // processes for bound in (place, place + 1))
        arguments = (
            __file__,
            "--crowd",
            endpoint,
            session,
            *map(str, (first, after - first, count + 2)),
        )
        child = await asyncio.create_subprocess_exec(
            sys.executable,
            *arguments,
            stdout=asyncio.subprocess.PIPE,
        )
        stack.push_async_callback(_end, child)
        started.append(child)
    return started


async def _end(child: asyncio.subprocess.Process) -> None:
    if child.returncode is None:
        child.kill()
    await child.wait()


async def see_each_other(crowds: list[asyncio.subprocess.Process]) -> int:
    """Wait until all modules of all processes see all; gives the number of their threads."""
    lines = [await crowd.stdout.readline() for crowd in crowds if crowd.stdout is not None]
    if not all(lines):
        raise RuntimeError("a process of modules has ended; its error stands above")
    return sum(map(int, lines))


async def run(count: int, processes: int, session: str) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{probe.getsockname()[1]}"
    options = BusOptions(connect=endpoint, realm=REALM)
    flags = ("--connect", endpoint, "--realm", REALM)
    async with contextlib.AsyncExitStack() as stack:
        router = await stack.enter_async_context(process("-m", "tca_bus", "router", *flags))
        await RouterListening(options).wait(router)
        central = await stack.enter_async_context(process("-m", "tca_bus", "central", *flags))
        await ModulePresent("central", options).wait(central)
        boss = await stack.enter_async_context(Module("boss", options=options))
        before = memory(router), memory(central)
        begun = time.monotonic()
        crowds = await start_crowds(stack, endpoint, count, processes, session)
        if not crowds:
            await stack.enter_async_context(process(__file__, "--serve", endpoint, str(count)))
        await eventually(lambda: len(boss.modules()) == count + 2, timeout=PATIENCE)
        print(f"{count} modules are seen after {time.monotonic() - begun:.1f} s", flush=True)
        if crowds:
            threads = await see_each_other(crowds)
            took = time.monotonic() - begun
            megabytes = sum(memory(crowd.pid) for crowd in crowds)
            print(f"all see each other after {took:.1f} s", flush=True)
            print(f"{processes} processes of modules: {threads} threads, {megabytes:.0f} MB")
        await put_to_work(boss, count)
        print(f"each has carried out a command after {time.monotonic() - begun:.1f} s")
        for name, was, pid in (("router", before[0], router), ("central", before[1], central)):
            print(f"{name}: {was:.0f} MB before, {memory(pid):.0f} MB after")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--modules", type=int, default=1000)
    parser.add_argument("--processes", type=int, default=0, help="of real modules; 0: stand-ins")
    ways = ("shared", "own")
    parser.add_argument("--session", choices=ways, default="shared", help="of real modules")
    parser.add_argument("--serve", nargs=2, help=argparse.SUPPRESS)
    parser.add_argument("--crowd", nargs=5, help=argparse.SUPPRESS)
    flags = parser.parse_args()
    if flags.serve:
        endpoint, count = flags.serve
        serve(endpoint, int(count))
    elif flags.crowd:
        endpoint, session, *numbers = flags.crowd
        asyncio.run(crowd(endpoint, session, *map(int, numbers)))
    else:
        check_limits(flags.modules, flags.processes, flags.session)
        asyncio.run(run(flags.modules, flags.processes, flags.session))


if __name__ == "__main__":
    main()
