"""The launcher in a real terminal: who reads the keyboard, whom Ctrl-C reaches."""

from __future__ import annotations

import asyncio
import os
import pty
import sys

import pytest

pytestmark = pytest.mark.process

LAUNCHER = """
import asyncio, fcntl, os, sys, termios
from tca_bus.launcher import Launcher, ProcessSpec

TALKER = "print('hello ' + input('name? '), flush=True); import time; time.sleep(600)"
SLEEPER = "print('up', flush=True); import time; time.sleep(600)"

async def main():
    python = [sys.executable, "-c"]
    talker = ProcessSpec("talker", [*python, TALKER], stdin="inherit", output="inherit")
    sleeper = ProcessSpec("sleeper", [*python, SLEEPER])
    async with Launcher([talker, sleeper], console=sys.stdout) as office:
        await office.serve_forever()

os.setsid()
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
try:
    asyncio.run(main())
except KeyboardInterrupt:
    print("all stopped")
"""


async def read_until(terminal, words, seen):
    loop = asyncio.get_running_loop()
    readable = asyncio.Event()
    loop.add_reader(terminal, readable.set)
    try:
        async with asyncio.timeout(30):
            while not all(word in "".join(seen) for word in words):
                await readable.wait()
                readable.clear()
                seen.append(os.read(terminal, 4096).decode())
    finally:
        loop.remove_reader(terminal)


async def test_one_process_talks_with_the_terminal_and_ctrl_c_stops_all():
    terminal, other_end = pty.openpty()
    launcher = await asyncio.create_subprocess_exec(
        sys.executable,
        "-c",
        LAUNCHER,
        stdin=other_end,
        stdout=other_end,
        stderr=other_end,
        env={key: value for key, value in os.environ.items() if key != "NO_COLOR"},
    )
    os.close(other_end)
    seen = []
    try:
        await read_until(terminal, ["name? ", "sleeper |\x1b[0m up"], seen)
        os.write(terminal, b"mitchell\n")
        await read_until(terminal, ["hello mitchell"], seen)
        os.write(terminal, b"\x03")
        await read_until(terminal, ["all stopped"], seen)
        assert await asyncio.wait_for(launcher.wait(), 30) == 0
    finally:
        if launcher.returncode is None:
            launcher.kill()
            await launcher.wait()
        os.close(terminal)
    told = "".join(seen)
    assert told.index("sleeper |\x1b[0m -- was killed by SIGTERM") < told.index(
        "talker  |\x1b[0m -- was killed by SIGTERM"
    )
