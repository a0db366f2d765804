"""What the robot's senses say at a tick, less what is not to be believed.

A sonar that is dead or stuck is left out; where it looks, what light sees or what its neighbours
hear stands in for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from navigate.body._health import Condition, LaserHealth, SonarHealth
from navigate.body._lasers import LIDAR, STRIPER, Laser, Sight
from navigate.body._odometry import Pose
from navigate.body._sonarring import bits_of, heard_ranges
from navigate.maps import Floats
from xavier_sim.messages import SONAR_COUNT, Sensors

RIGHT_BEFORE = 0.5
"""Metres within which what either neighbour of a sonar hears is before that sonar as well."""

NO_BEAMS: Floats = np.empty(0)
NOTHING_LIT: Floats = np.full(SONAR_COUNT, np.inf)


@dataclass(frozen=True, slots=True)
class Percept:
    """One tick of the senses.

    ``ring`` (24,) is what sonars hear, metres from the ring, with stand-ins for those that are
    unsound, and ``renewed`` has the bits of what is new in it; ``own`` and ``fresh`` are the same
    of sound sonars alone. ``sights`` are what lasers see that are right, ``lit`` (24,) the nearest
    of it in each cone; ``striper`` are the beams of one that is right, empty without. ``blind`` has
    the bits of unsound sonars for which only their neighbours stand in.
    """

    ring: Floats
    renewed: int
    own: Floats
    fresh: int
    sights: tuple[tuple[Laser, Sight], ...] = ()
    lit: Floats = field(default_factory=NOTHING_LIT.copy)
    striper: Floats = field(default_factory=NO_BEAMS.copy)
    blind: int = 0


class Perception:
    """Takes in sensors, and finds out which of them to believe."""

    STATE: ClassVar[tuple[str, ...]] = ("sonars", "striper")

    def __init__(self) -> None:
        self.sonars = SonarHealth()
        self.striper = LaserHealth(STRIPER)

    @property
    def faults(self) -> dict[str, str]:
        """What is not to be believed, and why: such as ``sonar 3`` being ``stuck``."""
        if not (self.striper.off or self.sonars.any_unsound):
            return {}
        unsound = np.flatnonzero(self.sonars.unsound).tolist()
        conditions = self.sonars.conditions
        faults = {f"sonar {i}": Condition(int(conditions[i])).name.lower() for i in unsound}
        return faults | ({"striper": Condition.OFF.name.lower()} if self.striper.off else {})

    def take_in(self, sensors: Sensors, odom: Pose) -> Percept:
        """What the sensors of a tick say."""
        ranges, fresh = heard_ranges(sensors), sensors.sonar_fresh
        striper = STRIPER.look(sensors.striper)
        lidar = LIDAR.look(sensors.lidar)
        if striper is not None:
            own = (
                np.where(self.sonars.unsound, np.inf, ranges) if self.sonars.any_unsound else ranges
            )
            self.striper.judge(own, fresh, striper, odom)
        if self.striper.off:
            striper = None
        sights = [(STRIPER, striper), (LIDAR, lidar)]
        seen = tuple((laser, sight) for laser, sight in sights if sight is not None)
        lit = _nearest([sight for _, sight in seen])
        self.sonars.judge(ranges, fresh, lit, odom)
        beams = NO_BEAMS if striper is None else striper.ranges
        unsound = self.sonars.unsound
        if not self.sonars.any_unsound:
            return Percept(ranges, fresh, ranges, fresh, seen, lit, beams)
        own = np.where(unsound, np.inf, ranges)
        ring, renewed = self._stand_in(own, fresh, lit, seen)
        trusted = fresh & ~bits_of(unsound)
        blind = unsound.copy()
        for laser, _ in seen:
            blind &= ~laser.whole
        return Percept(ring, renewed | trusted, own, trusted, seen, lit, beams, bits_of(blind))

    def _stand_in(
        self, own: Floats, fresh: int, lit: Floats, seen: Sequence[tuple[Laser, Sight]]
    ) -> tuple[Floats, int]:
        """The ring with stand-ins for what is unsound, and the bits of those that are new."""
        sonars = np.flatnonzero(self.sonars.unsound)
        left, right = own[(sonars + 1) % SONAR_COUNT], own[sonars - 1]
        nearer, farther = np.minimum(left, right), np.maximum(left, right)
        by_light = np.zeros(len(sonars), dtype=np.bool_)
        for laser, _ in seen:
            by_light |= laser.whole[sonars]
        # Neighbours overlap by a third of their cones: what is before the one between them both
        # hear, but for what is so near that the robot would run into it anyway.
        ring = own.copy()
        told = np.where(by_light, lit[sonars], np.minimum(farther, lit[sonars]))
        ring[sonars] = np.where(nearer < RIGHT_BEFORE, nearer, told)
        renewed = 0
        for sonar, is_lit in zip(sonars.tolist(), by_light.tolist(), strict=True):
            beside = (1 << (sonar + 1) % SONAR_COUNT) | (1 << (sonar - 1) % SONAR_COUNT)
            renewed |= (1 << sonar) * bool(is_lit or fresh & beside)
        return ring, renewed


def _nearest(sights: list[Sight]) -> Floats:
    if not sights:
        return NOTHING_LIT
    if len(sights) == 1:
        return sights[0].ring
    return np.minimum(sights[0].ring, sights[1].ring)
