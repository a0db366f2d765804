"""How fast the robot gets on, from what it has done: metres a second, and seconds a hand-over."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

from rogue.errands import Travel
from rogue.memory import TimedStep

BELIEF_SECONDS = 60.0
"""Driving for which the speed counts that was assumed before anything was driven."""

BELIEF_HANDOVERS = 3
"""Hand-overs for which the time counts that was assumed before there was one."""

DRIVE = "goto-"
HANDOVERS = frozenset({"acquire-item", "deliver-item", "return-item"})


def at_pace(travel: Travel, steps: Iterable[TimedStep]) -> Travel:
    """Travel with the mean speed and handling time of ``steps``, the oldest first.

    A drive counts from the room where the step before it ended, with all that made sure of the
    arrival; only steps that were done count.
    """
    known = list(steps)
    metres, seconds = travel.speed * BELIEF_SECONDS, BELIEF_SECONDS
    for before, step in pairwise(known):
        if step.operator.startswith(DRIVE) and step.is_done and before.room and step.room:
            metres += travel.distance(before.room, step.room)
            seconds += max(0.0, step.seconds)
    times = [
        max(0.0, step.seconds) for step in known if step.operator in HANDOVERS and step.is_done
    ]
    handling = travel.handling * BELIEF_HANDOVERS + sum(times)
    return replace(
        travel, speed=metres / seconds, handling=handling / (BELIEF_HANDOVERS + len(times))
    )
