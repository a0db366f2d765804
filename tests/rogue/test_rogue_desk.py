from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from rogue_fakes import FakeModule, prospects, reception

from rogue.memory import Store
from rogue.messages import (
    CancelRequest,
    ListRequests,
    PostRequest,
    ReadTrace,
    RequestState,
    ShowRequest,
    Why,
)
from rogue.requests import Desk, RequestBook, load_directory
from tca_bus import NoHandlerError, TaskError

ROOMS = {f"r-53{number:02d}": (0.0, float(number)) for number in range(1, 16)}


@pytest.fixture
async def module(tmp_path: Path) -> AsyncIterator[FakeModule]:
    async with Store(tmp_path) as store:
        module, directory = FakeModule(), load_directory()
        book = RequestBook(module, store, directory)

        async def rooms() -> dict[str, tuple[float, float]]:
            return ROOMS

        ready = reception(module, store, directory), prospects(module, store, book)
        Desk(module, store, book, *ready).open(rooms)
        yield module


def post(name: str = "a", **fields: object) -> PostRequest:
    values = {"id": name, "user": "mitchell", "item": "delivermail", **fields}
    return PostRequest.model_validate(values)


async def test_posting_twice_is_one_request(module: FakeModule):
    first = await module.ask(post())
    await module.clock.advance(5.0)
    assert await module.ask(post()) == first
    assert await module.ask(ListRequests()) == [first]


async def test_the_same_errand_is_told_of_unless_it_is_wanted_again(module: FakeModule):
    await module.ask(post())
    with pytest.raises(TaskError, match="as request 'a'") as caught:
        await module.ask(post("b"))
    assert (caught.value.name, caught.value.data["other"]) == ("duplicate", "a")
    assert (await module.ask(post("b", again=True))).id == "b"


async def test_an_errand_that_has_ended_may_be_asked_for_anew(module: FakeModule):
    await module.ask(post())
    await module.ask(CancelRequest(id="a"))
    assert (await module.ask(post("b"))).id == "b"


async def test_posting_twice_at_the_same_time_is_one_request(module: FakeModule):
    first, second = await asyncio.gather(module.ask(post()), module.ask(post()))
    assert first == second
    assert await module.ask(ListRequests()) == [first]


async def test_requests_are_listed_by_state_user_and_number(module: FakeModule):
    for number, user in enumerate(["mitchell", "jhm", "veloso"]):
        await module.ask(post(str(number), user=user))
    await module.ask(CancelRequest(id="1"))

    async def listed(**fields: object) -> list[str]:
        return [one.id for one in await module.ask(ListRequests.model_validate(fields))]

    assert await listed(states=["queued"]) == ["0", "2"]
    assert await listed(user="JHM") == ["1"]
    assert await listed(most=2) == ["1", "2"]
    assert await listed(most=1, open_only=True) == ["2"]


async def test_what_was_filled_in_is_shown(module: FakeModule):
    await module.ask(post(deliver="r-5301"))
    details = await module.ask(ShowRequest(id="a"))
    assert [(one.slot, one.source) for one in details.filled] == [
        ("pickup", "directory"),
        ("deadline", "default"),
    ]


async def test_an_id_belongs_to_one_errand(module: FakeModule):
    await module.ask(post())
    with pytest.raises(TaskError, match="belongs to another") as caught:
        await module.ask(post(item="deliverfax"))
    assert caught.value.name == "id_taken"


@pytest.mark.parametrize(
    ("fields", "name"),
    [
        ({"user": "nobody"}, "unknown_user"),
        ({"item": "pizza"}, "unknown_item"),
        ({"pickup": "r-1234"}, "unknown_room"),
        ({"pickup": "r-5313"}, "same_room"),
        ({"deadline": "whenever"}, "bad_deadline"),
    ],
)
async def test_what_is_wrong_is_refused_by_name_and_not_kept(module, fields, name):
    with pytest.raises(TaskError) as caught:
        await module.ask(post(**fields))
    assert caught.value.name == name
    assert set(caught.value.data) >= {"field", "value", "expected"}
    assert await module.ask(ListRequests()) == []


async def test_without_a_navigator_a_request_is_refused(tmp_path: Path):
    async with Store(tmp_path) as store:
        module, directory = FakeModule(), load_directory()

        async def rooms() -> dict[str, tuple[float, float]]:
            raise NoHandlerError("navigateRooms")

        book = RequestBook(module, store, directory)
        ready = reception(module, store, directory), prospects(module, store, book)
        Desk(module, store, book, *ready).open(rooms)
        with pytest.raises(TaskError, match="rooms is not there") as caught:
            await module.ask(post())
        assert caught.value.name == "not_ready"


async def test_a_canceled_request_stays_so(module: FakeModule):
    await module.ask(post())
    canceled = await module.ask(CancelRequest(id="a", reason="no need"))
    assert (canceled.state, canceled.reason) == (RequestState.CANCELED, "no need")
    assert await module.ask(CancelRequest(id="a", reason="once more")) == canceled


async def test_an_unknown_request_names_near_ones(module: FakeModule):
    await module.ask(post("monday"))
    with pytest.raises(TaskError, match="Did you mean 'monday'") as caught:
        await module.ask(ShowRequest(id="mondey"))
    assert caught.value.name == "unknown_request"


async def test_why_tells_the_story(module: FakeModule):
    await module.ask(post())
    await module.ask(CancelRequest(id="a", reason="no need"))
    report = await module.ask(Why(id="a"))
    assert "mitchell asked for delivermail from r-5303 to r-5313" in report.sentences[0]
    assert report.sentences[-1].endswith("It is canceled: no need.")


async def test_show_and_trace_are_there_from_the_start(module: FakeModule):
    await module.ask(post(why="for the review"))
    details = await module.ask(ShowRequest(id="a"))
    assert (details.why, details.on_tray, details.steps) == ("for the review", False, [])
    assert await module.ask(ReadTrace()) == []


async def test_the_trace_is_read_from_a_time_on(module: FakeModule, tmp_path: Path):
    async with Store(tmp_path) as store:
        for seconds in (0.0, 700.0, 900.0):
            await store.add_line(f"at {seconds:g}", module.clock.now() + seconds)
    await module.clock.advance(1000.0)
    lines = await module.ask(ReadTrace(since="10min"))
    assert [line.text for line in lines] == ["at 700", "at 900"]
    assert [line.text for line in await module.ask(ReadTrace(since="10min", after=2))] == ["at 900"]
    with pytest.raises(TaskError, match="since 'soon' cannot be read") as caught:
        await module.ask(ReadTrace(since="soon"))
    assert caught.value.name == "bad_time"
