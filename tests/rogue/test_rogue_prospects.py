"""Deadlines that cannot be met: said at once, put off, or warned of later."""

from __future__ import annotations

from collections.abc import AsyncIterator
from pathlib import Path

import pytest
from rogue_fakes import FakeModule, make_request, prospects

from rogue.errors import TooLateError
from rogue.memory import Store
from rogue.messages import Closing, DeliveryRequest, Filled, RequestState
from rogue.outcomes import StepOutcome
from rogue.requests import Prospects, RequestBook, load_directory

NOW = 1000.0
DEFAULT = (Filled(slot="deadline", value="1h", source="default"),)
TRAY = frozenset({("mitchell", "delivermail")})


class Scene:
    """A book and its prospects; the robot stands at r-5301."""

    def __init__(self, store: Store) -> None:
        self.module, self.store = FakeModule(), store
        self.book = RequestBook(self.module, store, load_directory())
        self.prospects: Prospects = prospects(self.module, store, self.book)

    async def accept(self, name: str, **fields: object) -> DeliveryRequest:
        request, _ = await self.prospects.in_time(make_request(name, **fields), ())
        await self.book.add(request, None)
        await self.prospects.review()
        return request

    async def warning(self, name: str) -> str | None:
        request = await self.store.request(name)
        assert request == (self.book.find(name) or request)
        return request.warning


@pytest.fixture
async def scene(tmp_path: Path) -> AsyncIterator[Scene]:
    async with Store(tmp_path) as store:
        scene = Scene(store)
        step = await store.begin_step("goto-pickup-loc", ("a", "r-5301"), [], 0.0)
        assert step is not None
        await store.end_step(step, StepOutcome(kind="done", room="r-5301"), 0.0)
        yield scene


async def test_what_can_be_done_in_time_is_taken_as_it_is(scene: Scene):
    request = make_request(deadline=NOW + 100.0)
    assert await scene.prospects.in_time(request, DEFAULT) == (request, DEFAULT)


async def test_a_way_that_alone_takes_too_long_is_refused_with_the_earliest_time(scene: Scene):
    with pytest.raises(TooLateError, match=r"the way alone takes that long, .* earliest") as caught:
        await scene.prospects.in_time(make_request(deadline=NOW + 60.0), ())
    # 12 rooms of 1.8 m at 0.5 m/s, and two stops of 20 s
    assert caught.value.earliest == pytest.approx(NOW + 83.2)
    objection = caught.value.objection
    assert (objection.field, objection.earliest) == ("deadline", pytest.approx(NOW + 83.2))


async def test_what_was_accepted_comes_first_and_is_named_as_the_reason(scene: Scene):
    for number in range(3):
        due = NOW + 150.0 + number
        await scene.accept(str(number), pickup="r-5301", deliver="r-5302", deadline=due)
    with pytest.raises(TooLateError, match="what was accepted before comes first") as caught:
        await scene.prospects.in_time(make_request("x", deadline=NOW + 100.0), ())
    assert caught.value.alone < NOW + 100.0 < caught.value.earliest


async def test_a_default_deadline_is_put_off_instead(scene: Scene):
    request, filled = await scene.prospects.in_time(make_request(deadline=NOW + 60.0), DEFAULT)
    assert request.deadline == NOW + 120.0
    assert filled == (Filled(slot="deadline", value="2min", source="default"),)


async def test_whoever_is_displaced_is_told_and_not_dropped(scene: Scene):
    await scene.accept("low", rank=1, pickup="r-5302", deliver="r-5315", deadline=NOW + 105.0)
    assert await scene.warning("low") is None
    urgent = make_request(
        "high", user="jhm", rank=8, pickup="r-5315", deliver="r-5301", deadline=NOW + 145.0
    )
    await scene.book.add(urgent, None)
    await scene.prospects.review()
    warning = await scene.warning("low")
    assert warning is not None
    assert warning.startswith("its deadline, ")
    assert scene.book.find("low") is not None
    assert await scene.store.notes("low") == [(NOW, warning)]
    await scene.prospects.review()
    assert len(await scene.store.notes("low")) == 1
    await scene.book.end(urgent, RequestState.CANCELED, "no need")
    await scene.prospects.review()
    assert await scene.warning("low") is None


async def test_one_that_is_given_up_needs_no_deadline_and_gets_no_warning(scene: Scene):
    request = make_request(
        state=RequestState.UNDERWAY,
        then="back",
        closing=Closing(state=RequestState.FAILED, reason="too late", since=0.0),
        deadline=0.0,
    )
    await scene.book.add(request, None)
    await scene.prospects.review()
    assert await scene.warning("a") is None


async def test_what_has_ended_is_not_warned_of(scene: Scene):
    request = await scene.accept("a")
    await scene.book.end(request, RequestState.CANCELED, "no need")
    await scene.book.warn("a", "too late")
    assert await scene.warning("a") is None
