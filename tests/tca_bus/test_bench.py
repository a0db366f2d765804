"""The benchmark runs, and says of every contender what it measured or what is missing."""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).parents[2] / "bench" / "bus.py"


@pytest.mark.slow
@pytest.mark.bus
@pytest.mark.process
@pytest.mark.timeout(180)
async def test_the_benchmark_prints_a_table_with_all_that_was_asked_for():
    little = ("--rounds", "1", "--calls", "5", "--sizes", "64")
    few = ("--only", "ours", "bare-pubsub", "zmq")
    process = await asyncio.create_subprocess_exec(
        sys.executable, str(BENCH), *little, *few, stdout=asyncio.subprocess.PIPE
    )
    try:
        async with asyncio.timeout(170):
            output, _ = await process.communicate()
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()
    text = output.decode()
    assert process.returncode == 0
    for what in ("Query, one at a time", "Informs, as fast", "Command: ", "Goal with ten", "Aims"):
        assert f"**{what}" in text
    assert "| tca_bus, router " in text
    assert "| bare Zenoh pub/sub, router " in text
    assert ("| pyzmq " in text) != ("Not measured: pyzmq" in text)
