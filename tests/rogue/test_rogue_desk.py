from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from rogue_fakes import FakeModule

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

        Desk(module, store, book, directory).open(rooms)
        yield module


def post(name: str = "a", **fields: str) -> PostRequest:
    return PostRequest(**{"id": name, "user": "mitchell", "item": "delivermail", **fields})


async def test_posting_twice_is_one_request(module: FakeModule):
    first = await module.ask(post())
    await module.clock.advance(5.0)
    assert await module.ask(post()) == first
    assert await module.ask(ListRequests()) == [first]


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
    assert await module.ask(ListRequests()) == []


async def test_without_a_navigator_a_request_is_refused(tmp_path: Path):
    async with Store(tmp_path) as store:
        module, directory = FakeModule(), load_directory()

        async def rooms() -> dict[str, tuple[float, float]]:
            raise NoHandlerError("navigateRooms")

        Desk(module, store, RequestBook(module, store, directory), directory).open(rooms)
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
