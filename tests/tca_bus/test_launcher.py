"""The launcher with small processes: start, restart, end, and what it leaves behind."""

from __future__ import annotations

import asyncio
import io
import os
import random
import signal
import socket
import sys
from contextlib import suppress
from pathlib import Path

import pytest

from tca_bus import BusOptions, TimedOutError
from tca_bus.launcher import (
    GaveUpError,
    Launcher,
    NoPortError,
    PortInUseError,
    ProcessSpec,
    RestartPolicy,
    RouterListening,
    StartFailedError,
    free_port,
)
from tca_bus.launcher._ports import HIGHEST, LOWEST
from tca_bus.testing import eventually

pytestmark = pytest.mark.process

HASTY = RestartPolicy(first_delay=0.01, longest_delay=0.05, most=3, window=60.0)

SLEEP = "import time; print('up', flush=True); time.sleep(600)"
STUBBORN = "import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN);" + SLEEP
CRASH = "import sys; print('it broke', file=sys.stderr); sys.exit(3)"
OFFSPRING = """
import subprocess, sys, time
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
print(child.pid, flush=True)
time.sleep(600)
"""


class HasSaid:
    """Ready when the process has written a line."""

    def __init__(self, office, name, word):
        self.office, self.name, self.word = office, name, word

    async def before_first_start(self):
        pass

    async def wait(self, pid):
        await eventually(lambda: self.word in self.office[0].logs(self.name))


def python(name, code, **options):
    return ProcessSpec(name, [sys.executable, "-c", code], **options)


def runs(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


async def test_processes_run_inside_the_block_only():
    async with Launcher([python("one", SLEEP), python("two", SLEEP)]) as office:
        pids = [office.pid("one"), office.pid("two")]
        await eventually(lambda: office.logs("one") == office.logs("two") == ["up"])
        assert all(runs(pid) for pid in pids)
    assert not any(runs(pid) for pid in pids)


async def test_each_starts_when_those_before_it_are_ready_and_ends_in_reverse():
    shown = io.StringIO()
    office = []
    specs = [
        python("first", SLEEP, ready=HasSaid(office, "first", "up")),
        python("second", SLEEP, ready=HasSaid(office, "second", "up")),
    ]
    office.append(Launcher(specs, console=shown))
    async with office[0]:
        pass
    told = [line.split(" | ")[0].strip() for line in shown.getvalue().splitlines() if "--" in line]
    assert told == ["first", "second", "second", "first"]


async def test_a_process_gets_the_bus_options_and_its_own_environment():
    names = ("TCA_CONNECT", "TCA_REALM", "TCA_LINKS", "MINE")
    code = f"import os; print(*[os.environ[name] for name in {names}])"
    options = BusOptions(connect="tcp/127.0.0.1:1", realm="here", links="direct")
    spec = python("one", code, env={"MINE": "x"}, restart=None)
    async with Launcher([spec], options) as office:
        await eventually(lambda: office.logs("one"))
        assert office.logs("one") == ["tcp/127.0.0.1:1 here direct x"]


async def test_a_killed_process_is_started_again():
    async with Launcher([python("one", SLEEP, restart=HASTY)]) as office:
        for turn in range(3):
            before = office.pid("one")
            os.kill(before, signal.SIGKILL)
            assert await office.wait_restarted("one", beyond=turn) == turn + 1
            assert office.pid("one") != before
        assert office.restarts("one") == 3


async def test_one_that_crashes_too_often_is_given_up_and_the_block_cancelled():
    pids = []

    async def run():
        specs = [python("sound", SLEEP), python("broken", CRASH, restart=HASTY)]
        async with Launcher(specs) as office:
            pids.append(office.pid("sound"))
            await office.serve_forever()

    with pytest.raises(GaveUpError) as caught:
        await run()
    assert caught.value.process == "broken"
    assert caught.value.crashes == 4
    assert "it broke" in caught.value.tail
    assert "crashed 4 times within 60 s" in str(caught.value)
    assert not runs(pids[0])


async def test_an_end_at_the_start_shows_the_last_lines():
    office = []
    spec = python("broken", CRASH, ready=HasSaid(office, "broken", "never"))
    office.append(Launcher([python("sound", SLEEP), spec]))
    with pytest.raises(StartFailedError) as caught:
        await office[0].__aenter__()
    assert "ended with exit code 3 before it was ready" in str(caught.value)
    assert "it broke" in str(caught.value)
    assert office[0].pid("sound") is None


@pytest.mark.parametrize(("code", "passed_on"), [(2, 2), (3, 1), (5, 1)])
async def test_only_wrong_usage_is_passed_on_as_an_exit_code(code, passed_on):
    office = []
    spec = python("picky", f"raise SystemExit({code})", ready=HasSaid(office, "picky", "never"))
    office.append(Launcher([spec]))
    with pytest.raises(StartFailedError) as caught:
        await office[0].__aenter__()
    assert caught.value.exit_code == passed_on


async def test_one_that_never_gets_ready_is_given_up_in_time():
    office = []
    spec = python("slow", SLEEP, ready=HasSaid(office, "slow", "never"), ready_timeout=0.5)
    office.append(Launcher([spec]))
    with pytest.raises(StartFailedError, match=r"not ready within 0\.5 s") as caught:
        await office[0].__aenter__()
    assert caught.value.process == "slow"
    assert office[0].pid("slow") is None


async def test_a_program_that_is_not_there_is_named():
    with pytest.raises(StartFailedError, match="'/no/such/program' cannot be run"):
        await Launcher([ProcessSpec("ghost", ["/no/such/program"])]).__aenter__()


async def test_one_that_ignores_sigterm_is_killed():
    shown = io.StringIO()
    async with Launcher([python("deaf", STUBBORN, grace=0.2)], console=shown) as office:
        await eventually(lambda: office.logs("deaf") == ["up"])
        pid = office.pid("deaf")
    assert not runs(pid)
    assert "deaf | -- was killed by SIGKILL" in shown.getvalue()


async def test_what_a_process_started_ends_with_it():
    async with Launcher([python("parent", OFFSPRING)]) as office:
        await eventually(lambda: office.logs("parent"))
        grandchild = int(office.logs("parent")[0])
        assert runs(grandchild)
    await eventually(lambda: not runs(grandchild))


async def test_what_a_crashed_process_started_ends_with_it_though_it_is_restarted():
    async with Launcher([python("parent", OFFSPRING, restart=HASTY)]) as office:
        await eventually(lambda: office.logs("parent"))
        os.kill(office.pid("parent"), signal.SIGKILL)
        await office.wait_restarted("parent", beyond=0)
        await eventually(lambda: len(office.logs("parent")) == 2)
        first, second = (int(line) for line in office.logs("parent"))
        await eventually(lambda: not runs(first))
        assert runs(second)


async def test_cancelling_the_block_stops_all():
    pids = []

    async def run():
        async with Launcher([python("one", SLEEP), python("two", STUBBORN, grace=0.2)]) as office:
            pids.extend([office.pid("one"), office.pid("two")])
            await office.serve_forever()

    task = asyncio.create_task(run())
    await eventually(lambda: pids)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert not any(runs(pid) for pid in pids)


async def test_a_second_cancel_kills_what_dawdles():
    pids = []

    async def run():
        async with Launcher([python("deaf", STUBBORN, grace=600.0)]) as office:
            await eventually(lambda: office.logs("deaf"))
            pids.append(office.pid("deaf"))
            await office.serve_forever()

    task = asyncio.create_task(run())
    await eventually(lambda: pids)
    for _ in range(2):
        task.cancel()
        await asyncio.wait([task], timeout=0.1)
    with pytest.raises(asyncio.CancelledError):
        await task
    with pytest.raises(ProcessLookupError):
        os.kill(pids[0], 0)


async def test_an_error_in_the_block_comes_out_as_it_is():
    with pytest.raises(LookupError, match="mine"):
        async with Launcher([python("one", SLEEP)]):
            raise LookupError("mine")


async def test_quiet_processes_write_to_files(tmp_path):
    async with Launcher([python("one", SLEEP)], log_dir=tmp_path / "logs") as office:
        await eventually(lambda: office.logs("one") == ["up"])
    lines = (tmp_path / "logs" / "one.log").read_text().splitlines()
    assert "up" in lines
    assert lines[-1] == "-- was killed by SIGTERM"


async def test_a_prompt_without_a_line_end_is_shown():
    code = "import sys, time; sys.stdout.write('name? '); sys.stdout.flush(); time.sleep(600)"
    async with Launcher([python("one", code)]) as office:
        await eventually(lambda: office.logs("one"))
        assert office.logs("one") == ["name? "]


async def test_waiting_for_a_restart_is_bounded():
    async with Launcher([python("one", SLEEP)]) as office:
        with pytest.raises(TimedOutError, match="restart of one"):
            await office.wait_restarted("one", timeout=0.05)


async def test_a_port_in_use_is_told_before_anything_runs():
    server = await asyncio.start_server(lambda _reader, writer: writer.close(), "127.0.0.1", 0)
    port = server.sockets[0].getsockname()[1]
    options = BusOptions(connect=f"tcp/127.0.0.1:{port}")
    spec = python("router", SLEEP, ready=RouterListening(options))
    async with server:
        with pytest.raises(PortInUseError, match=f"already listens at tcp/127.0.0.1:{port}"):
            await Launcher([spec], options).__aenter__()


LAUNCHER = """
import asyncio, sys
from tca_bus.launcher import Launcher, ProcessSpec

GUARDED = '''
import os, threading, time
def watch():
    os.read(int(os.environ["TCA_PARENT_FD"]), 1)
    os._exit(0)
threading.Thread(target=watch, daemon=True).start()
time.sleep(600)
'''

async def main():
    specs = [ProcessSpec(name, [sys.executable, "-c", GUARDED]) for name in ("one", "two")]
    async with Launcher(specs) as office:
        print(office.pid("one"), office.pid("two"), flush=True)
        await office.serve_forever()

RUN(main())
"""


async def launch(loop):
    code = LAUNCHER.replace("RUN", f"__import__({loop!r}).run")
    launcher = await asyncio.create_subprocess_exec(
        sys.executable, "-c", code, stdout=asyncio.subprocess.PIPE
    )
    line = await asyncio.wait_for(launcher.stdout.readline(), 30)
    return launcher, [int(word) for word in line.split()]


@pytest.mark.parametrize("loop", ["asyncio", "uvloop"])
async def test_a_launcher_killed_by_force_leaves_nothing(loop):
    launcher, pids = await launch(loop)
    assert all(runs(pid) for pid in pids)
    launcher.kill()
    await launcher.wait()
    await eventually(lambda: not any(runs(pid) for pid in pids))


@pytest.mark.parametrize("loop", ["asyncio", "uvloop"])
async def test_ctrl_c_reaches_the_launcher_only(loop):
    launcher, pids = await launch(loop)
    try:
        groups = {os.getpgid(pid) for pid in pids}
        assert groups == set(pids)
        launcher.send_signal(signal.SIGINT)
        await asyncio.wait_for(launcher.wait(), 30)
        assert not any(runs(pid) for pid in pids)
    finally:
        with suppress(ProcessLookupError):
            launcher.kill()
        await launcher.wait()


def test_a_free_port_is_none_at_which_somebody_listens(monkeypatch):
    port = free_port()
    assert LOWEST <= port <= HIGHEST
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", port))
        taken.listen()
        monkeypatch.setattr(random, "randint", lambda low, high: port)
        with pytest.raises(NoPortError, match="that were tried are taken"):
            free_port()
