"""Doors passed on the way elsewhere: whether they stand open, as they look from beside them.

A sense that looks into a doorway meets the line of the wall where the door is shut, and nothing
until the far end of the room where it is open. A reading may err, somebody may stand there, and
the robot may be elsewhere than it believes: a door counts as shut only when all that was sensed of
it, from one side of its middle to the other, met the line.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable
from typing import ClassVar, NamedTuple

from navigate.body import CONE_HALF, PITCH, RING_RADIUS, Laser, Percept, Pose, Sight, wrap
from navigate.maps import Passage, Point, frame
from xavier_sim.messages import SONAR_COUNT

NEAREST, FARTHEST = 0.5, 2.0
"""Metres before the line of a door between which it is looked at."""

ASIDE = 0.8
"""Metres beside its middle within which it is."""

STRAIGHT = math.radians(22.0)
"""Radians off the straight way in up to which a sonar looks well."""

ASKANCE = math.radians(60.0)
"""The same for a beam of light."""

BESIDE_JAMB = 0.1
"""Metres from a jamb from which a beam is in the opening for sure."""

MOST_BEAMS = 6
"""Beams of one laser that are looked along at a tick, of those that go through one opening."""

ON_LINE, BEHIND = 0.15, 0.5
"""Metres within which the line is met, and beyond it from which it is not."""

FEWEST_MET, FEWEST_PAST = 4, 3
"""Readings that it takes to call a door shut, and open."""

OFF_MIDDLE, ACROSS = 0.02, 0.15
"""Metres to either side of the middle that the readings of a shut door reach, and in all.

So an open door is called shut only by a robot that is a quarter of a metre beside where it
believes: its sonars' cones fill half of the opening.
"""

MOST_ODD = 0.4
"""Share of the readings of an open door that may have met its jambs, or something at its line."""

MOST_CELLS = 1024
"""Square metres of the floor for which the doors around are kept at most."""

LONGEST = 15.0
"""Seconds after which what was seen of a door is of no use: it may have moved since."""


_Reading = tuple[float, float]
"""Where it crosses the line of a door, metres to the left of its middle, and how far it goes on."""


class Passed(NamedTuple):
    """A door that the robot has passed, and how it stood."""

    door: str
    is_open: bool


class _Sighting(NamedTuple):
    """What was sensed of a door since ``began``, seconds: readings that met its line or went past.

    ``lowest`` and ``highest`` are how far those that met it reach to the right and left of its
    middle, metres.
    """

    began: float
    met: int = 0
    past: int = 0
    lowest: float = 0.0
    highest: float = 0.0

    def judge(self, door: str) -> Passed | None:
        """What that tells, if it tells anything."""
        if self.past == 0:
            spread = self.highest - self.lowest > ACROSS
            sure = spread and min(-self.lowest, self.highest) > OFF_MIDDLE
            return Passed(door, False) if self.met >= FEWEST_MET and sure else None
        odd = self.met > MOST_ODD * (self.met + self.past)
        return Passed(door, True) if self.past >= FEWEST_PAST and not odd else None


class _Stand(NamedTuple):
    """Where a robot is: metres before the line of a door and to the left of its middle.

    ``turned`` are radians by which it looks to the left of the straight way in.
    """

    before: float
    left: float
    turned: float


class DoorWatch:
    """Looks at doors in passing.

    Args:
        doors: of the map.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_kept",)

    def __init__(self, doors: Iterable[Passage]) -> None:
        self._doors = tuple(doors)
        self._around = functools.lru_cache(maxsize=MOST_CELLS)(self._doors_around)
        self._sightings: dict[str, _Sighting] = {}

    def forget(self) -> None:
        """Drop what was begun: the robot does not know where it is."""
        self._sightings.clear()

    def look(self, pose: Pose, senses: Percept, time: float) -> list[Passed]:
        """Take in a tick at a believed ``pose``; the doors that the robot has just left behind."""
        before, near = self._sightings, self._near(pose)
        if not before and not near:
            return []
        self._sightings = now = {}
        for door in near:
            if (stand := _stand(door, pose)) is not None:
                sighting = before.pop(door.name, None)
                if sighting is None or time - sighting.began > LONGEST:
                    sighting = _Sighting(time)
                now[door.name] = _take_in(sighting, door.width / 2, stand, senses)
        if not before:
            return []
        judged = (sighting.judge(door) for door, sighting in before.items())
        return [passed for passed in judged if passed]

    def _near(self, pose: Pose) -> tuple[Passage, ...]:
        return self._around(math.floor(pose[0]), math.floor(pose[1]))

    def _doors_around(self, column: int, row: int) -> tuple[Passage, ...]:
        """The doors that are looked at from some point of a metre of the floor."""
        middle = (column + 0.5, row + 0.5)
        return tuple(door for door in self._doors if _is_near(door, middle))

    @property
    def _kept(self) -> dict[str, list[float]]:
        return {door: list(sighting) for door, sighting in self._sightings.items()}

    @_kept.setter
    def _kept(self, state: dict[str, list[float]]) -> None:
        self._sightings = {
            door: _Sighting(began, int(met), int(past), lowest, highest)
            for door, (began, met, past, lowest, highest) in state.items()
        }


def _is_near(door: Passage, middle: Point) -> bool:
    """Whether a door is looked at from some point of the metre around ``middle``."""
    beyond, left = frame(door, *middle)
    return abs(beyond) < FARTHEST + 0.5 and abs(left) < ASIDE + 0.5


def _stand(door: Passage, pose: Pose) -> _Stand | None:
    """How the robot stands before a door on either side of it, None where it sees nothing of it."""
    beyond, left = frame(door, pose[0], pose[1])
    if not (NEAREST < abs(beyond) < FARTHEST and abs(left) < ASIDE):
        return None
    side = -1.0 if beyond > 0.0 else 1.0
    ahead = math.atan2(side * door.normal[1], side * door.normal[0])
    return _Stand(abs(beyond), side * left, wrap(pose[2] - ahead))


def _take_in(sighting: _Sighting, half: float, stand: _Stand, senses: Percept) -> _Sighting:
    readings = _readings(half, stand, senses)
    if not readings:
        return sighting
    began, met, past, lowest, highest = sighting
    for crossing, more in readings:
        if more > BEHIND:
            past += 1
        elif abs(more) < ON_LINE:
            met += 1
            lowest, highest = min(lowest, crossing), max(highest, crossing)
    return _Sighting(began, met, past, lowest, highest)


def _readings(half: float, stand: _Stand, senses: Percept) -> list[_Reading]:
    """What is new at a tick."""
    straight, readings = round(-stand.turned / PITCH), list[_Reading]()
    for sonar in (straight - 1, straight, straight + 1):
        number = sonar % SONAR_COUNT
        if senses.fresh >> number & 1:
            look = stand.turned + sonar * PITCH
            readings += _hear(half, stand, look, float(senses.own[number]))
    for laser, sight in senses.sights:
        if abs(stand.turned) < ASKANCE + laser.view / 2:
            readings += _see(half, stand, laser, sight)
    return readings


def _hear(half: float, stand: _Stand, look: float, reading: float) -> list[_Reading]:
    """What a sonar tells whose whole cone goes into the opening.

    It looks ``look`` radians to the left of the straight way in.
    """
    aside, askance = stand.before * math.tan(look), abs(look)
    crossing, away = stand.left + aside, stand.before - RING_RADIUS * math.cos(look)
    reach = away * (math.tan(askance + CONE_HALF) - abs(aside) / stand.before)
    if askance > STRAIGHT or abs(crossing) + reach > half:
        return []
    return [(crossing, reading - away / math.cos(max(0.0, askance - CONE_HALF)))]


def _see(half: float, stand: _Stand, laser: Laser, sight: Sight) -> list[_Reading]:
    """What beams of light tell that go into the opening."""
    before = stand.before - laser.ahead * math.cos(stand.turned)
    left = stand.left + laser.ahead * math.sin(stand.turned)
    inside, step = half - BESIDE_JAMB, laser.spacing
    right_most = max(-ASKANCE, math.atan2(-inside - left, before))
    left_most = min(ASKANCE, math.atan2(inside - left, before))
    first = math.ceil((wrap(right_most - stand.turned) + laser.view / 2) / step)
    count = max(0, math.floor((left_most - right_most) / step))
    beams = range(first, first + count, 1 + count // MOST_BEAMS)
    readings = list[_Reading]()
    for beam in beams:
        # A beam that comes back from nowhere may have been lost.
        if 0 <= beam < laser.beams and math.isfinite(reading := float(sight.ranges[beam])):
            look = stand.turned + float(laser.bearings[beam])
            crossing, along = left + before * math.tan(look), before / math.cos(look)
            readings.append((crossing, reading - along))
    return readings
