from __future__ import annotations

import sqlite3
from collections.abc import AsyncIterator
from contextlib import closing
from importlib import resources
from pathlib import Path

import pytest
from rogue_fakes import make_request

from rogue.errors import StoreError
from rogue.memory import Facts, Store
from rogue.messages import RequestState
from rogue.outcomes import Outcome, StepOutcome


@pytest.fixture
async def store(tmp_path: Path) -> AsyncIterator[Store]:
    async with Store(tmp_path) as store:
        yield store


async def test_requests_come_back_as_they_were_kept(store: Store):
    first, second = make_request("a"), make_request("b", user="jhm")
    await store.add_request(first, "for the review")
    await store.add_request(second, None)
    assert await store.requests() == [first, second]
    assert await store.request("b") == second
    assert await store.request("c") is None
    assert await store.why("a") == "for the review"


async def test_an_ended_request_does_not_change_again(store: Store):
    await store.add_request(make_request(), None)
    failed = make_request(state=RequestState.FAILED, finished=9.0, reason="no way")
    assert await store.change_request(failed, note="no way")
    assert not await store.change_request(make_request(state=RequestState.COMPLETED, finished=10.0))
    assert await store.request("a") == failed
    assert await store.requests(open_only=True) == []
    assert await store.notes("a") == [(9.0, "no way")]


async def test_a_step_ends_with_all_it_changed_or_not_at_all(tmp_path: Path):
    underway = make_request(state=RequestState.UNDERWAY)
    async with Store(tmp_path) as store:
        await store.add_request(make_request(), None)
        step = await store.begin_step("ACQUIRE-ITEM", ("r-5303", "mitchell"), [underway], 2.0)
        await store.keep_outcome(step, 3, Outcome(value={"answer": "y"}))
    async with Store(tmp_path) as store:
        assert await store.open_step() == step
        assert (await store.outcomes(step))[3].value == {"answer": "y"}
        assert await store.request("a") == underway
        thing = ("mitchell", "delivermail")
        outcome = StepOutcome(kind="done", room="r-5303", placed=(thing,))
        await store.end_step(step, outcome, 4.0)
    async with Store(tmp_path) as store:
        assert await store.open_step() is None
        assert await store.facts() == Facts("r-5303", frozenset({thing}))
        assert await store.outcomes(step) == {}
        (view,) = await store.steps_of("a")
        assert (view.operator, view.state) == ("ACQUIRE-ITEM r-5303 mitchell", "done")


async def test_a_line_of_a_step_is_kept_once(store: Store):
    free = await store.add_line("Listening", 1.0)
    first = await store.add_line("SENDING", 2.0, step=7, position=1)
    assert free is not None
    assert first is not None
    assert await store.add_line("SENDING", 3.0, step=7, position=1) is None
    assert await store.add_line("Listening", 4.0) is not None
    assert [line.text for line in await store.lines(0, 10)] == ["Listening", "SENDING", "Listening"]
    assert [line.text for line in await store.lines(first.seq, 1)] == ["Listening"]


async def test_identity_stays_and_differs(tmp_path: Path):
    async with Store(tmp_path / "one") as one, Store(tmp_path / "two") as two:
        name = await one.identity()
        assert name != await two.identity()
    async with Store(tmp_path / "one") as one:
        assert await one.identity() == name


async def test_a_file_that_is_no_store_is_refused(tmp_path: Path):
    (tmp_path / "rogue.db").write_bytes(b"not a database" * 100)
    with pytest.raises(StoreError, match="no store of requests"):
        async with Store(tmp_path):
            pass


async def test_a_store_of_a_newer_version_is_refused(tmp_path: Path):
    async with Store(tmp_path) as store:
        await store._base.link.execute("PRAGMA user_version=99")
    with pytest.raises(StoreError, match="newer version"):
        async with Store(tmp_path):
            pass


async def test_a_store_of_the_first_schema_is_brought_up_to_date(tmp_path: Path):
    old = resources.files("rogue.memory").joinpath("migrations", "0001_requests.sql")
    with closing(sqlite3.connect(tmp_path / "rogue.db")) as link:
        link.executescript(
            old.read_text(encoding="utf-8")
            + """
            INSERT INTO requests (id, user, item, pickup, deliver, state, rank, posted, deadline)
            VALUES ('a', 'mitchell', 'delivermail', 'r-5303', 'r-5313', 'queued', 5, 1000, 4600);
            INSERT INTO steps (operator, arguments, requests, state, started)
            VALUES ('goto-pickup-loc', '["mitchell", "r-5303"]', '["a"]', 'done', 1.0);
            PRAGMA user_version = 1;
            """
        )
    async with Store(tmp_path) as store:
        assert await store.requests() == [make_request()]
        assert await store.filled("a") == []
        assert [step.state for step in await store.steps_of("a")] == ["done"]
