"""What goes wrong during a soak: one kind of fault, once for all or again and again."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, Literal, get_args

import numpy as np

from xavier_sim.messages import (
    AnyFault,
    CameraPower,
    Kidnap,
    LaserOffset,
    Slip,
    SonarFault,
    WheelSlip,
)
from xavier_sim.noise import restore_stream, stream, stream_state
from xavier_sim.profile import TICK, RobotProfile
from xavier_sim.running import make_fault
from xavier_sim.world import NotFreeError, World

FaultKind = Literal["camera", "kidnap", "laser", "slip", "sonar-dead", "sonar-stuck", "wheels"]

FAULT_KINDS: tuple[FaultKind, ...] = get_args(FaultKind)

LASTING: dict[str, AnyFault] = {
    "camera": CameraPower(on=False),
    "laser": LaserOffset(metres=0.1, turn=math.radians(3.0)),
    "sonar-dead": SonarFault(number=0, state="dead"),
    "sonar-stuck": SonarFault(number=2, state="stuck", metres=0.5),
    "wheels": WheelSlip(share=0.1, veer=math.radians(1.0)),
}
"""Faults from the first tick to the last: the sonar that looks ahead hears nothing, or the one 30
degrees to its left hears something half a metre away; a wheel slips, so that the robot goes a
tenth less far than it counts, and turns by a degree a metre."""

Random = np.random.Generator


def _slipped(random: Random, _world: World) -> AnyFault:
    """Wheels that count half a metre wrong, give or take, and a heading that jumps by degrees."""
    metres, turn = random.normal(0.0, 0.5), random.normal(0.0, math.radians(3.0))
    return Slip(metres=float(metres), turn=float(turn))


def _kidnapped(random: Random, world: World) -> AnyFault:
    """The robot in a room whose door stands open, looking anywhere."""
    doors = world.doors()
    rooms = [room for room in sorted(world.plan.places) if doors.get(room, True)]
    rooms = rooms or sorted(world.plan.places)
    room = rooms[int(random.integers(len(rooms)))]
    return Kidnap(room=room, theta=float(random.uniform(-math.pi, math.pi)))


AGAIN: dict[str, tuple[float, Callable[[Random, World], AnyFault]]] = {
    "kidnap": (1200.0, _kidnapped),
    "slip": (600.0, _slipped),
}
"""Faults that come again after so many simulated seconds."""


def possible_faults(profile: RobotProfile) -> tuple[FaultKind, ...]:
    """The kinds of faults for which a robot has what is to fail."""
    return tuple(kind for kind in FAULT_KINDS if _is_possible(LASTING.get(kind), profile))


def _is_possible(fault: AnyFault | None, profile: RobotProfile) -> bool:
    match fault:
        case SonarFault():
            return profile.sonar is not None
        case LaserOffset():
            return profile.striper is not None or profile.lidar is not None
        case _:
            return True


class Mishaps:
    """Does the faults of one kind to a world, or none."""

    def __init__(self, kind: FaultKind | None, seed: int) -> None:
        self._kind, self._random = kind, stream(seed, "soak-mishaps")
        self._next = round(AGAIN[kind][0] / TICK) if kind in AGAIN else None

    def begin(self, world: World) -> bool:
        """Do what lasts to a new world; whether there was something.

        Raises:
            NoSensorError: the robot has no sensor of the kind that is to fail.
        """
        if self._kind not in LASTING:
            return False
        make_fault(world, LASTING[self._kind])
        return True

    def tend(self, world: World) -> bool:
        """Do what is due at this tick; whether it was done.

        A robot that fits nowhere is moved at the next one.
        """
        if self._next is None or self._kind is None or world.tick < self._next:
            return False
        pause, fault = AGAIN[self._kind]
        try:
            make_fault(world, fault(self._random, world))
        except NotFreeError:
            return False
        self._next += round(pause / TICK)
        return True

    def snapshot(self) -> dict[str, Any]:
        """What `restore` needs."""
        return {"next": self._next, "random": stream_state(self._random)}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self._next = state["next"]
        restore_stream(self._random, state["random"])
