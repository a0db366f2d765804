"""Giving up a request at each stage: what becomes of it, and of its item."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from rogue_fakes import FakeModule, make_request

from rogue.memory import Facts, Step, Store
from rogue.messages import DeliveryRequest, RequestState
from rogue.outcomes import StepOutcome
from rogue.requests import RequestBook, load_directory

TRAY = frozenset({("mitchell", "delivermail")})
CANCELED = (RequestState.CANCELED, "no need")


class Scene:
    """A book with one request, served as far as a test wants."""

    def __init__(self, store: Store, book: RequestBook) -> None:
        self.store, self.book = store, book

    async def begin(self, operator: str) -> Step:
        request = self.book.find("a")
        assert request is not None
        begun = self.book.as_begun(request)
        arguments = ("r-5303", "mitchell", "delivermail")
        step = await self.store.begin_step(operator, arguments, [begun], 1.0)
        assert step is not None
        await self.book.took_effect(begun)
        return step

    async def end(self, step: Step, facts: Facts, *, kind: str = "done") -> None:
        """End a step as the executor does."""
        request = self.book.find("a")
        assert request is not None
        changed = []
        if step.operator == "deliver-item":
            changed = [self.book.as_ended(request, RequestState.COMPLETED, None, facts)]
        elif kind == "failed":
            changed = [self.book.as_ended(request, RequestState.FAILED, "nobody there", facts)]
        gone = await self.store.facts()
        outcome = StepOutcome.model_validate(
            {
                "kind": kind,
                "room": facts.room,
                "placed": facts.tray,
                "gone": gone.tray - facts.tray,
            }
        )
        for one in await self.store.end_step(step, outcome, 2.0, changed=changed):
            await self.book.took_effect(one)

    async def acquired(self) -> None:
        await self.end(await self.begin("acquire-item"), Facts("r-5303", TRAY))

    async def kept(self) -> DeliveryRequest:
        request = await self.store.request("a")
        assert request is not None
        return request


@pytest.fixture
async def scene(tmp_path: Path) -> AsyncIterator[Scene]:
    async with Store(tmp_path) as store:
        book = RequestBook(FakeModule(), store, load_directory())
        await book.add(make_request(), None)
        yield Scene(store, book)


async def test_before_the_item_is_on_the_tray_it_ends_at_once(scene: Scene):
    await scene.begin("goto-pickup-loc")
    await scene.book.give_up("a", *CANCELED)
    ended = await scene.kept()
    assert (ended.state, ended.reason, ended.closing) == (*CANCELED, None)
    assert scene.book.find("a") is None


@pytest.mark.parametrize(
    ("item", "room", "where"),
    [
        ("back", "r-5303", "the item is back in r-5303"),
        ("deliver", "r-5313", "the item was delivered to r-5313 all the same"),
    ],
)
async def test_what_is_on_the_tray_is_brought_away_first(scene: Scene, item, room, where):
    await scene.acquired()
    await scene.book.give_up("a", *CANCELED, item)
    closing = scene.book.find("a")
    assert closing == await scene.kept()
    assert (closing.state, closing.destination) == (RequestState.UNDERWAY, room)
    await scene.end(await scene.begin("deliver-item"), Facts(room))
    ended = await scene.kept()
    assert (ended.state, ended.reason) == (RequestState.CANCELED, f"no need; {where}")


async def test_what_is_kept_stays_on_the_tray(scene: Scene):
    await scene.acquired()
    await scene.book.give_up("a", *CANCELED, "keep")
    assert (await scene.kept()).reason == (
        "no need; Tom Mitchell's mail delivery is still on the tray"
    )


async def test_the_user_may_think_again_about_the_item(scene: Scene):
    await scene.acquired()
    await scene.book.give_up("a", *CANCELED, "back")
    await scene.book.give_up("a", RequestState.CANCELED, "oh well", "deliver")
    closing = await scene.kept()
    assert closing.then == "deliver"
    assert closing.closing is not None
    assert closing.closing.reason == "no need"


async def test_while_the_item_is_handed_over_the_hand_over_decides(scene: Scene):
    step = await scene.begin("acquire-item")
    await scene.book.give_up("a", *CANCELED)
    assert (await scene.kept()).state is RequestState.UNDERWAY
    await scene.end(step, Facts("r-5303"), kind="failed")
    ended = await scene.kept()
    assert (ended.state, ended.reason) == (RequestState.CANCELED, "no need; nobody there")


async def test_what_could_not_be_brought_away_is_said_to_be_on_the_tray(scene: Scene):
    await scene.acquired()
    await scene.book.give_up("a", *CANCELED)
    await scene.end(await scene.begin("return-item"), Facts("r-5303", TRAY), kind="failed")
    ended = await scene.kept()
    assert ended.state is RequestState.CANCELED
    assert (
        ended.reason == "no need; nobody there; Tom Mitchell's mail delivery is still on the tray"
    )


async def test_a_second_request_for_the_same_does_not_own_what_is_on_the_tray(scene: Scene):
    await scene.acquired()
    await scene.book.add(make_request("b"), None)
    await scene.book.give_up("b", *CANCELED)
    second = await scene.store.request("b")
    assert second is not None
    assert (second.state, second.closing) == (RequestState.CANCELED, None)


async def test_a_closing_request_survives_a_restart_and_has_no_deadline(scene: Scene):
    await scene.acquired()
    await scene.book.give_up("a", RequestState.FAILED, "too late")
    again = RequestBook(FakeModule(), scene.store, load_directory())
    await again.load()
    assert again.find("a") == await scene.kept()
    assert again.next_deadline() is None


async def test_a_step_does_not_begin_for_a_request_that_was_taken_back(scene: Scene):
    request = scene.book.find("a")
    assert request is not None
    await scene.book.give_up("a", *CANCELED)
    begun = scene.book.as_begun(request)
    assert await scene.store.begin_step("acquire-item", (), [begun], 1.0) is None
    assert await scene.store.open_step() is None
