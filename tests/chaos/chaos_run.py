"""Kills processes at random while tasks run, and says which promises were broken.

    uv run python tests/chaos/chaos_run.py --seed 1 --kills 50 --tasks 500

starts a router, central and ten modules as ``rogue up`` would, sends the tasks, kills -9 a random
process again and again, and ends with 1 if an acknowledged task did not end exactly once. The
seed decides what is sent and who is killed after which task.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import secrets
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

from chaos_crew import FETCH, LIFT, PATIENCE
from chaos_ledger import Ledger
from chaos_plan import Plan, PlannedKill, PlannedTask, make_plan
from chaos_record import Record, Struck, Told
from chaos_verdict import broken_promises

from tca_bus import (
    BusGoneError,
    BusOptions,
    KilledError,
    Module,
    NoHandlerError,
    TaskFailedError,
    TaskHandle,
    TaskState,
    TcaError,
    TimedOutError,
)
from tca_bus._protocol import FindTask, ReadLog
from tca_bus.launcher import (
    Launcher,
    ModulePresent,
    ProcessSpec,
    RestartPolicy,
    RouterListening,
    free_port,
)
from tca_bus.testing import eventually

CREW = Path(__file__).with_name("chaos_crew.py")

MOST_OPEN = 24
"""Top-level tasks that are under way at once."""

END_PATIENCE = 180.0
"""Wall seconds from its acknowledgement in which a task must end."""

ALWAYS = RestartPolicy(first_delay=0.1, longest_delay=1.0, calm_after=1.0, most=10_000)


def chaos_specs(plan: Plan, options: BusOptions, folder: Path) -> list[ProcessSpec]:
    """The processes, as a user would start them."""
    tca = (sys.executable, "-m", "tca_bus")
    ledger = str(folder / "ledger")
    router = ProcessSpec(
        "router", (*tca, "router"), ready=RouterListening(options), restart=ALWAYS, after=()
    )
    central = ProcessSpec(
        "central",
        (*tca, "central", "--data", str(folder)),
        ready=ModulePresent("central", options),
        restart=ALWAYS,
        after=("router",),
    )
    crew = [
        ProcessSpec(
            name,
            (sys.executable, str(CREW), name, ledger),
            ready=ModulePresent(name, options),
            restart=ALWAYS,
            after=("router",),
        )
        for name in plan.modules
    ]
    return [router, central, *crew]


class ChaosRun:
    """One run: sends, kills, and records."""

    def __init__(self, plan: Plan, launcher: Launcher, chief: Module) -> None:
        self.record = Record(plan)
        self._launcher = launcher
        self._chief = chief
        self._open = asyncio.Semaphore(MOST_OPEN)
        self._sent = asyncio.Condition()
        self._count = 0

    async def go(self) -> None:
        """Send all tasks, carry out all kills, and wait for every end."""
        begun = time.monotonic()
        watching = asyncio.create_task(self._watch(), name="chaos.watch")
        async with asyncio.TaskGroup() as group:
            group.create_task(self._kill_all(), name="chaos.kills")
            for task in self.record.plan.tasks:
                await self._open.acquire()
                group.create_task(self._follow(task), name=f"chaos.{task.id}")
                async with self._sent:
                    self._count += 1
                    self._sent.notify_all()
        await self._look_back()
        watching.cancel()
        self.record.seconds = time.monotonic() - begun

    async def _watch(self) -> None:
        async with self._chief.watch_statuses(size=100_000) as statuses:
            async for status in statuses:
                self.record.published.setdefault(status.id, []).append(status)

    async def _follow(self, task: PlannedTask) -> None:
        try:
            handle = await self._submit(task)
            self.record.acknowledged[task.id] = handle.status
            async with asyncio.timeout(END_PATIENCE):
                if task.killed_after is not None:
                    await asyncio.sleep(task.killed_after)
                    await self._until_told(lambda: handle.kill("the sender changed its mind"))
                self.record.told[task.id] = await _told(handle)
        except TimeoutError:
            self.record.unended[task.id] = handle.status.model_dump_json()
        finally:
            self._open.release()

    async def _submit(self, task: PlannedTask) -> TaskHandle:
        if task.is_goal:
            message = FETCH[task.policy](
                work=task.work,
                fails=task.fails,
                children=task.children,
                child_policy=task.child_policy,
                lenient=task.lenient,
            )
        else:
            message = LIFT[task.policy](work=task.work, fails=task.fails)
        return await self._until_told(
            lambda: self._chief.submit(
                message,
                id=task.id,
                constraints=task.constraints,
                wait_for_handler=PATIENCE,
                timeout=PATIENCE,
            )
        )

    async def _until_told(self, ask):
        """Ask central again when it was out of reach for longer than one call waits."""
        while True:
            with suppress(BusGoneError, NoHandlerError, TimedOutError):
                return await ask()

    async def _kill_all(self) -> None:
        for kill in self.record.plan.kills:
            await self._kill(kill)

    async def _kill(self, kill: PlannedKill) -> None:
        async with self._sent:
            await self._sent.wait_for(lambda: self._count > kill.after)
        await asyncio.sleep(kill.pause)
        victim = kill.victim
        await eventually(lambda: self._launcher.pid(victim), timeout=PATIENCE, what=f"{victim}")
        pid = self._launcher.pid(victim)
        os.kill(pid, signal.SIGKILL)
        self.record.struck.append(Struck(victim, pid, time.monotonic()))
        await eventually(lambda: self._launcher.pid(victim) != pid, what=f"the end of {victim}")

    async def _look_back(self) -> None:
        """Ask central, after all is over, what it has kept."""
        for id in self.record.acknowledged:
            with suppress(TcaError):
                self.record.final[id] = await self._ask(FindTask(id=id))
        while lines := await self._ask(ReadLog(after=self._last_line, most=10_000)):
            self.record.log += lines

    @property
    def _last_line(self) -> int:
        return self.record.log[-1].number if self.record.log else 0

    async def _ask(self, question):
        await self._chief.wait_for(type(question), timeout=PATIENCE)
        return await self._chief.query(question, timeout=PATIENCE)


async def _told(handle: TaskHandle) -> Told:
    try:
        result = await handle.result()
    except KilledError:
        return Told(TaskState.KILLED)
    except TaskFailedError as error:
        return Told(TaskState.FAILED, error.failure.name)
    return Told(TaskState.ACHIEVED, result=result)


def free_endpoint() -> str:
    """A loopback endpoint that nobody listens on."""
    return f"tcp/127.0.0.1:{free_port()}"


@asynccontextmanager
async def chaos(plan: Plan, folder: Path) -> AsyncIterator[ChaosRun]:
    """Start everything for a run; all processes end with the block."""
    options = BusOptions(connect=free_endpoint(), realm=f"chaos-{plan.seed}")
    launcher = Launcher(chaos_specs(plan, options, folder), options, log_dir=folder)
    async with launcher, Module("chief", options=options) as chief:
        await chief.wait_for("tca.submit", *FETCH.values(), *LIFT.values(), timeout=30.0)
        yield ChaosRun(plan, launcher, chief)


async def run_chaos(plan: Plan, folder: Path) -> Record:
    """Carry out a plan; the processes' logs, the journal and the ledger lie in ``folder``."""
    async with chaos(plan, folder) as run:
        await run.go()
    run.record.deeds = list(Ledger(folder / "ledger").entries())
    return run.record


def summary(record: Record) -> str:
    """What happened, in three lines."""
    kills = Counter("module" if s.victim.startswith("crew") else s.victim for s in record.struck)
    ends = Counter(f"{told.state} {told.failure}".strip() for told in record.told.values())
    tries = Counter(entry.attempt for entry in record.deeds if entry.deed == "begun")
    return (
        f"{len(record.struck)} kills in {record.seconds:.0f} s: {_counts(kills)}\n"
        f"{len(record.acknowledged)} tasks acknowledged: {_counts(ends)}\n"
        f"{sum(tries.values())} handlers begun: "
        + ", ".join(f"{count} at attempt {attempt}" for attempt, count in sorted(tries.items()))
    )


def _counts(counter: Counter[str]) -> str:
    return ", ".join(f"{count} {what}" for what, count in counter.most_common())


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=secrets.randbelow(100_000))
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--tasks", type=int, default=500)
    parser.add_argument("--modules", type=int, default=10)
    parser.add_argument("--keep", type=Path, help="where logs, journal and ledger stay")
    flags = parser.parse_args()
    say(f"seed {flags.seed}")
    plan = make_plan(seed=flags.seed, tasks=flags.tasks, kills=flags.kills, modules=flags.modules)
    with tempfile.TemporaryDirectory() as temporary:
        folder = flags.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        record = asyncio.run(run_chaos(plan, folder))
    say(summary(record))
    broken = broken_promises(record)
    say("\n".join(broken or ["every promise was kept"]))
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
