from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rogue_fakes import make_request

from rogue.errands import Travel
from rogue.memory import Facts, Store, TimedStep
from rogue.outcomes import StepOutcome
from rogue.requests import Outlook, at_pace

PRIOR = Travel(distance=lambda start, end: 24.0 if start != end else 0.0, speed=0.4, handling=30.0)


def drive(room: str, seconds: float) -> TimedStep:
    return TimedStep("goto-pickup-loc", seconds, room, is_done=True)


def hand_over(seconds: float, *, is_done: bool = True) -> TimedStep:
    return TimedStep("acquire-item", seconds, "a", is_done)


def test_without_steps_what_was_assumed_counts():
    assert at_pace(PRIOR, []) == PRIOR


def test_what_was_driven_and_handed_over_counts_the_more_the_more_there_is():
    assert at_pace(PRIOR, [drive("a", 9.0), drive("b", 30.0)]).speed == pytest.approx(48.0 / 90.0)
    many = [drive("ab"[n % 2], 30.0) for n in range(400)]
    assert at_pace(PRIOR, many).speed == pytest.approx(0.8, abs=0.01)
    assert at_pace(PRIOR, [hand_over(10.0)] * 3).handling == pytest.approx(20.0)


def test_steps_that_came_to_nothing_say_nothing():
    lost = TimedStep("goto-pickup-loc", 500.0, None, is_done=False)
    assert at_pace(PRIOR, [drive("a", 9.0), lost, hand_over(300.0, is_done=False)]) == PRIOR


@given(
    st.lists(
        st.builds(
            TimedStep,
            st.sampled_from(["goto-deliver-loc", "acquire-item", "other"]),
            st.floats(-10.0, 1e4),
            st.sampled_from(["a", "b", None]),
            st.booleans(),
        ),
        max_size=40,
    )
)
def test_any_past_gives_a_pace_that_travel_takes(steps: list[TimedStep]):
    pace = at_pace(PRIOR, steps)
    assert pace.speed > 0.0
    assert pace.handling >= 0.0


async def test_the_store_tells_how_long_its_latest_steps_took(tmp_path: Path):
    async with Store(tmp_path) as store:
        for number in range(3):
            step = await store.begin_step("goto-pickup-loc", ("u", "a"), [], 10.0 * number)
            assert step is not None
            outcome = StepOutcome(kind="done", room=f"r{number}")
            await store.end_step(step, outcome, 10.0 * number + number)
        assert await store.timed_steps(2) == [drive("r1", 1.0), drive("r2", 2.0)]


def test_up_to_forty_errands_the_outlook_depends_on_nothing_earlier():
    requests = [
        make_request(f"q{n}", pickup=f"r-53{n:02d}", deliver=f"r-53{n + 1:02d}", deadline=9e9)
        for n in range(30)
    ]
    travel = Travel(distance=lambda start, end: abs(float(start[2:]) - float(end[2:])))
    facts = Facts("r-5301")
    used = Outlook()
    for count in (3, 12, 25, 30):
        used.expected(requests[:count], travel=travel, facts=facts, now=0.0)
    fresh = Outlook()
    told = [
        one.promise(requests[0], requests[1:], travel=travel, facts=facts, now=0.0)
        for one in (used, fresh)
    ]
    assert told[0] == told[1]
