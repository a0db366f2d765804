"""Decisions are kept with what is committed next, and bounded."""

from __future__ import annotations

import asyncio
import signal
import sys
from pathlib import Path

import pytest
from rogue_fakes import make_request

from rogue.explain import Decision, DecisionKind, Rival
from rogue.memory import Store
from rogue.memory._decisions import MOST, MOST_WAITING

FULL = Decision(
    time=5.0,
    kind=DecisionKind.OVERTAKEN,
    requests=("a",),
    rule="nearest-room",
    chosen="<goto-pickup-loc jhm r-5311>",
    over=("<goto-pickup-loc mitchell r-5303>",),
    rivals=(Rival("b", 8),),
    reason="no way",
    until=9.5,
)


def routine(time: float, *requests: str) -> Decision:
    return Decision(time=time, kind=DecisionKind.BINDINGS, requests=requests or ("a",))


async def test_a_decision_comes_back_as_it_was_recorded(tmp_path: Path):
    async with Store(tmp_path) as store:
        store.record([FULL])
        assert await store.decisions("a") == [FULL]
        assert await store.decisions("b") == []


async def test_a_decision_is_found_at_each_request_that_it_concerns(tmp_path: Path):
    async with Store(tmp_path) as store:
        store.record([routine(1.0, "a", "b")])
        assert await store.decisions("a") == [routine(1.0, "a")]
        assert await store.decisions("b") == [routine(1.0, "b")]


async def test_decisions_ride_on_the_next_commit(tmp_path: Path):
    async with Store(tmp_path) as store:
        store.record([FULL])
        async with Store(tmp_path) as other:
            assert await other.decisions("a") == []
            await store.add_request(make_request(), None)
            assert await other.decisions("a") == [FULL]


async def test_a_failed_transaction_loses_no_decision(tmp_path: Path):
    async with Store(tmp_path) as store:
        await store.add_request(make_request(), None)
        store.record([FULL])
        with pytest.raises(Exception, match="UNIQUE"):
            await store.add_request(make_request(), None)
        assert await store.decisions("a") == [FULL]


async def test_decisions_are_written_when_the_store_is_closed(tmp_path: Path):
    async with Store(tmp_path) as store:
        store.record([FULL])
    async with Store(tmp_path) as store:
        assert await store.decisions("a") == [FULL]


async def test_of_many_decisions_the_oldest_routine_ones_are_forgotten(tmp_path: Path):
    async with Store(tmp_path) as store:
        store.record([FULL, *(routine(float(time)) for time in range(2 * MOST))])
        kept = await store.decisions("a")
        assert len(kept) == MOST
        assert kept[0] == FULL
        assert kept[-1].time == 2 * MOST - 1
        assert await store.forgotten("a") == MOST + 1
        assert await store.forgotten("b") == 0
        store.record([routine(9999.0)])
        await store.flush()
        assert await store.forgotten("a") == MOST + 2


async def test_where_all_are_important_the_oldest_go(tmp_path: Path):
    steps = [
        Decision(time=float(time), kind=DecisionKind.STEP, requests=("a",)) for time in range(300)
    ]
    async with Store(tmp_path) as store:
        store.record(steps)
        assert await store.decisions("a") == steps[-MOST:]


async def test_what_waits_is_bounded(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    async with Store(tmp_path) as store:
        store.record(routine(float(time)) for time in range(MOST_WAITING + 5))
        assert "5 decisions were forgotten" in caplog.text
        assert (await store.decisions("a"))[-1].time == MOST_WAITING + 4


KILLED = """
import asyncio, os, signal, sys
from pathlib import Path
from rogue.explain import Decision, DecisionKind
from rogue.memory import Store

async def main():
    async with Store(Path(sys.argv[1])) as store:
        store.record([Decision(time=1.0, kind=DecisionKind.STEP, requests=("a",), chosen="x")])
        await store.add_line("a line", 2.0)
        os.kill(os.getpid(), signal.SIGKILL)

asyncio.run(main())
"""


@pytest.mark.process
async def test_what_was_decided_before_a_kill_by_force_is_there(tmp_path: Path):
    process = await asyncio.create_subprocess_exec(sys.executable, "-c", KILLED, str(tmp_path))
    assert await process.wait() == -signal.SIGKILL
    async with Store(tmp_path) as store:
        [decision] = await store.decisions("a")
    assert (decision.kind, decision.chosen) == (DecisionKind.STEP, "x")
