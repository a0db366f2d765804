"""``rogue up`` as a user types it."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from pathlib import Path

import pytest

from tca_bus.launcher import free_port

pytestmark = [pytest.mark.scenario, pytest.mark.process, pytest.mark.timeout(120)]


async def spawn(port: int, *words: str, **more: str) -> asyncio.subprocess.Process:
    return await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        *words,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        env={**os.environ, "TCA_CONNECT": f"tcp/127.0.0.1:{port}", "TCA_REALM": "test", **more},
    )


def is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


async def test_the_office_opens_serves_and_closes_without_a_trace(tmp_path: Path):
    port = free_port()
    up = await spawn(port, "rogue", "up", "--speed", "max", "--data", str(tmp_path))
    assert up.stderr is not None
    pids = set()
    async for line in up.stderr:
        if b"ready after" in line:
            pids.add(int(line.split()[-1]))
        if b"The office is open" in line:
            break
    else:
        pytest.fail("the office did not open")
    assert len(pids) == 6
    drain = asyncio.create_task(up.stderr.read(), name="drain")
    listed = await spawn(port, "rogue", "requests", "--json")
    assert await listed.communicate() == (b"[]\n", b"")
    second = await spawn(port, "rogue", "up", "--data", str(tmp_path / "other"))
    _, said = await second.communicate()
    assert second.returncode == 2
    assert b"something already listens" in said
    up.send_signal(signal.SIGTERM)
    assert await up.wait() == 0
    await drain
    assert not [pid for pid in pids if is_alive(pid)]


async def test_a_secure_office_delivers_and_shuts_strangers_out(tmp_path: Path):
    tls = f"tls/127.0.0.1:{free_port()}"
    words = ("rogue", "up", "--secure", "--speed", "max", "--data", str(tmp_path))
    up = await spawn(0, *words, TCA_CONNECT=tls)
    assert up.stderr is not None
    async for line in up.stderr:
        if b"The office is open" in line:
            break
    else:
        pytest.fail("the office did not open")
    drain = asyncio.create_task(up.stderr.read(), name="drain")
    guest = {"TCA_CONNECT": tls, "TCA_KEYS": str(tmp_path / "keys")}
    request = ("rogue", "request", "delivermail", "--user", "mitchell", "--wait")
    delivered = await spawn(0, *request, **guest)
    said, _ = await delivered.communicate()
    assert (delivered.returncode, b"completed" in said) == (0, True)
    drive = ("tca_bus", "inform", "xavierDrive", '{"tick": 0, "speed": 1, "turn": 0}')
    stranger = await spawn(0, *drive, TCA_CONNECT=tls.replace("tls/", "tcp/"))
    _, said = await stranger.communicate()
    assert (stranger.returncode, b"closes the door" in said) == (7, True)
    up.send_signal(signal.SIGTERM)
    assert await up.wait() == 0
    await drain


async def test_a_map_that_is_not_there_is_named(tmp_path: Path):
    words = ("rogue", "up", "--data", str(tmp_path), "--map", "nowhere.yaml")
    up = await spawn(free_port(), *words)
    _, said = await up.communicate()
    assert up.returncode == 2
    assert b"nowhere.yaml" in said
