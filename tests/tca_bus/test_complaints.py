"""A cause is told once, and again with its count; a loop that stands still is named."""

from __future__ import annotations

import asyncio
import sys
from pathlib import Path

import pytest

from tca_bus import Module, Query
from tca_bus._complaints import MOST_CAUSES, PERIOD, Complaints
from tca_bus.testing import bus, eventually


class Ask(Query[int]):
    number: int = 0


class Block(Query[None]):
    wire_name = "block"

    seconds: float


class Watch:
    def __init__(self):
        self.time = 0.0

    def __call__(self):
        return self.time


def test_a_cause_is_told_once_and_then_with_its_count():
    now = Watch()
    complaints = Complaints(now)
    assert complaints.tell("a", "first") == "first"
    assert [complaints.tell("a", "again") for _ in range(3)] == [None] * 3
    assert complaints.tell("b", "other") == "other"
    now.time = PERIOD
    assert complaints.tell("a", "later") == (
        "later (and 3 more like it since the last time this was told)"
    )
    assert complaints.tell("a", "again") is None


def test_what_was_quiet_for_a_period_is_new():
    now = Watch()
    complaints = Complaints(now)
    complaints.tell("a", "first")
    now.time = PERIOD
    assert complaints.tell("a", "first") == "first"


def test_endless_causes_do_not_fill_the_log():
    now = Watch()
    complaints = Complaints(now)
    told = [complaints.tell(f"cause {n}", f"{n}") for n in range(5000)]
    assert sum(text is not None for text in told) == MOST_CAUSES + 1
    assert len(complaints._told) == MOST_CAUSES + 1
    now.time = PERIOD
    assert complaints.tell("cause 4999", "x").startswith("x")


@pytest.mark.bus
async def test_a_handler_that_fails_again_and_again_is_named_once(caplog):
    async with bus() as options, Module("me", options=options) as me:

        @me.handler(Ask)
        async def ask(message, context):
            raise RuntimeError(f"no {message.number}")

        for number in range(20):
            with pytest.raises(Exception, match=f"RuntimeError: no {number}"):
                await me.query(Ask(number=number))
        failures = [record for record in caplog.records if "handler of ask" in record.message]
        assert len(failures) == 1
        assert failures[0].exc_info is not None


@pytest.mark.bus
@pytest.mark.process
async def test_a_handler_that_blocks_its_loop_is_named_and_holds_up_nobody_else():
    blocker = str(Path(__file__).with_name("bus_blocker.py"))
    async with bus() as options, Module("me", options=options) as me:
        me.serve(Ask, answer)
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, blocker, options.connect, options.realm),
            stderr=asyncio.subprocess.PIPE,
        )
        try:
            await me.wait_for(Block, timeout=30.0)
            blocking = asyncio.create_task(me.query(Block(seconds=4.0), timeout=30.0))
            line = ""
            while "has stood still" not in line:
                line = (await process.stderr.readline()).decode()
                assert await me.query(Ask(number=1)) == 1
            place = (await process.stderr.read(1000)).decode()
            assert "module 'blocker'" in line
            assert "bus_blocker.py" in place
            assert "in spin" in place
            await blocking
            assert await me.query(Ask(number=2), to="blocker") == 2
        finally:
            process.kill()
            await process.communicate()


async def answer(message, context):
    return message.number


@pytest.mark.bus
async def test_a_handler_that_never_returns_fills_its_own_places_only(monkeypatch, caplog):
    monkeypatch.setattr("tca_bus._serving.MOST_RUNNING", 3)
    async with bus() as options, Module("server", options=options) as server:
        stuck: list[float] = []

        async def never(message, context):
            stuck.append(message.seconds)
            await asyncio.get_running_loop().create_future()

        server.serve(Block, never)
        server.serve(Ask, answer)
        async with Module("me", options=options) as me:
            await me.wait_for(Block, Ask, timeout=10.0)
            waiting = [asyncio.create_task(me.query(Block(seconds=n))) for n in range(3)]
            await eventually(lambda: len(stuck) == 3)
            for _ in range(5):
                with pytest.raises(PermissionError, match="too many waiting"):
                    await me.query(Block(seconds=9))
                assert await me.query(Ask(number=5)) == 5
            for task in waiting:
                task.cancel()
            await asyncio.wait(waiting)
        told = [record for record in caplog.records if "block has 3 queries" in record.message]
        assert len(told) == 1
