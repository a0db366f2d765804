"""What a navigator makes of the people around it when it reckons where it is."""

from __future__ import annotations

import json

import numpy as np
import pytest
from corridor import Corridor, standing
from navigate_loop import Loop

from navigate.driving._strangers import Stranger
from navigate.driving._view import WayBlocked

AHEAD = 0b111
"""The bits of the first three sonars."""


@pytest.fixture
def loop():
    return Loop(seed=3)


def somebody(loop):
    """Somebody beside the robot, met twice just now."""
    x, y, _ = loop.navigator.pose
    spot, now = (x + 0.6, y), loop.navigator.time
    return Stranger(spot, now, now, stood=spot, eye=(x, y), heard=2)


def told(loop, monkeypatch):
    """Which sonars the localizer is told of, from now on."""
    fresh, sense = [], loop.navigator.localizer.sense

    def listen(ranges, bits, *, still, striper):
        fresh.append(bits)
        sense(ranges, bits, still=still, striper=striper)

    monkeypatch.setattr(loop.navigator.localizer, "sense", listen)
    monkeypatch.setattr(
        type(loop.navigator.strangers), "explained", lambda _self, _ranges, _pose, _spaces: AHEAD
    )
    return fresh


def test_sonars_that_hear_strangers_tell_nothing_of_the_map(loop, monkeypatch):
    loop.start("r-5304")
    fresh = told(loop, monkeypatch)
    for _ in range(12):
        loop.navigator.strangers.around = [somebody(loop)]
        loop.tick()
    assert loop.world.truth().metres > 0.0
    assert not any(bits & AHEAD for bits in fresh)
    assert np.bitwise_or.reduce(fresh) == (1 << 24) - 1 & ~AHEAD


def test_to_a_robot_that_is_lost_all_sonars_tell(loop, monkeypatch):
    loop.navigator.localizer.forget()
    assert loop.navigator.localizer.lost
    fresh = told(loop, monkeypatch)
    for _ in range(6):
        loop.navigator.strangers.around = [somebody(loop)]
        loop.tick()
    assert any(bits & AHEAD for bits in fresh)


@pytest.mark.parametrize(
    "jump",
    [
        lambda navigator: navigator.forget_after(0.0),
        lambda navigator: navigator.set_position("r-5304"),
        lambda navigator: navigator.set_pose((5.0, 30.0, 0.0)),
        lambda navigator: navigator.restore(navigator.snapshot()),
    ],
    ids=["clock", "room", "pose", "restart"],
)
def test_strangers_are_forgotten_where_the_robot_is_elsewhere_than_it_believed(loop, jump):
    loop.navigator.strangers.around = [somebody(loop)]
    jump(loop.navigator)
    assert loop.navigator.strangers.around == []


def test_strangers_are_part_of_the_state_of_a_navigator(loop):
    loop.navigator.strangers.around = [somebody(loop)]
    state = json.loads(json.dumps(loop.navigator.freeze()))
    other = Loop(seed=3).navigator
    other.thaw(state)
    assert other.strangers.around == loop.navigator.strangers.around


def test_where_somebody_stands_at_a_corner_the_robot_may_turn_before_it():
    through, before = (Corridor(standing(9.0, 0.0), width=1.6) for _ in range(2))
    blocked = through.drive_way((0.0, 0.0), (8.4, 0.0))
    assert isinstance(blocked, WayBlocked)
    assert before.drive_way((0.0, 0.0), (8.4, 0.0), settle=0.6) is None
    assert before.touched is through.touched is None
    assert before.time < through.time - 5.0
