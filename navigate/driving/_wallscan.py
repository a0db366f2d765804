"""What a laser sees of a wall as the robot turns before it: its line, and the openings in it.

A shut door and the wall beside an open one look the same from straight ahead. Beams to both sides
tell them apart: somewhere along the line they go through.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navigate.body import Laser, Pose
from navigate.maps import Floats

OFF_LINE = 0.4
"""Metres by which the wall may be nearer or farther than expected."""

LEANS: Floats = np.radians(np.arange(-20.0, 20.5, 1.0))
"""Radians by which it may lean against what is expected."""

BIN = 0.05
"""Metres of a bin across the line, and of one along it."""

MEETS, BEYOND = 0.1, 0.3
"""Metres from the line within which a beam meets it, and behind it from which it goes through."""

LEAST_COSINE = 0.3
"""Of the angle at which a beam is of use: along the wall it tells nothing of where it ends."""

ALONG = 2.0
"""Metres to either side within which openings are looked for."""

FEWEST_POINTS, FEWEST_BEAMS = 30, 2
"""Of the wall to know its line by, and of a bin to call it open."""

NARROWER, WIDER = 0.2, 0.15
"""Metres by which an opening may seem narrower or wider than the door."""

UNKNOWN, MET, OPEN = 0, 1, 2

_BINS = round(2.0 * ALONG / BIN)
_PLACES: Floats = np.linspace(-ALONG + BIN / 2, ALONG - BIN / 2, _BINS)


class Line(NamedTuple):
    """A wall before the robot: metres from it, at right angles, and the direction of those."""

    away: float
    heading: float


class Opening(NamedTuple):
    """An opening in the wall: metres from the robot to its line, metres to the left to its middle.

    ``heading`` is the direction straight through, radians in odometry.
    """

    away: float
    left: float
    heading: float


class WallSeen(NamedTuple):
    """What is seen of a wall: the nearest ``opening`` that is as wide as a door, if any.

    ``gap`` are metres, within half its width of where it is expected, at which light goes through:
    of a door in which somebody stands some are left.
    """

    opening: Opening | None
    gap: float


NOTHING_SEEN = WallSeen(None, 0.0)


class WallScan:
    """Beams gathered while the robot turns on the spot.

    Args:
        odom: where it stands, as odometry says.
        expected: where the wall is expected.
    """

    def __init__(self, odom: Pose, expected: Line) -> None:
        self._at, self._expected = np.array(odom[:2]), expected
        self._beams: list[Floats] = []

    def add(self, odom: Pose, laser: Laser, ranges: Floats) -> None:
        """Take in the ``ranges`` (beams,) of a laser, metres, inf where nothing was seen."""
        cos, sin = math.cos(odom[2]), math.sin(odom[2])
        start = np.array(odom[:2]) - self._at + laser.ahead * np.array([cos, sin])
        beams = np.empty((laser.beams, 5))
        beams[:, :2] = start
        beams[:, 2] = odom[2] + laser.bearings
        beams[:, 3] = np.minimum(ranges, laser.farthest)
        beams[:, 4] = laser.farthest
        self._beams.append(beams)

    def look(self, width: float, *, expected: float, within: float) -> WallSeen:
        """What is seen of a door that is so many metres wide.

        Args:
            width: of the door.
            expected: metres to the left of the robot, where its middle should be.
            within: metres of that where an opening may be.
        """
        if not self._beams:
            return NOTHING_SEEN
        beams = np.concatenate(self._beams)
        line = _find_line(beams, self._expected)
        if line is None:
            return NOTHING_SEEN
        states = _states(beams, line)
        gap = float((states == OPEN)[np.abs(_PLACES - expected) < width / 2].sum()) * BIN
        middles = _middles(states, width)
        nearest = min(middles, key=lambda left: abs(left - expected), default=math.inf)
        if abs(nearest - expected) > within:
            return WallSeen(None, gap)
        return WallSeen(Opening(line.away, nearest, line.heading), gap)


def _find_line(beams: Floats, expected: Line) -> Line | None:
    """The line that most points lie on, of those that are about where the wall is expected."""
    hits = beams[beams[:, 3] < beams[:, 4]]
    x = hits[:, 0] + hits[:, 3] * np.cos(hits[:, 2])
    y = hits[:, 1] + hits[:, 3] * np.sin(hits[:, 2])
    headings = expected.heading + LEANS
    away = np.cos(headings)[:, None] * x + np.sin(headings)[:, None] * y
    bins = np.floor((away - expected.away + OFF_LINE) / BIN).astype(np.int64)
    count = round(2.0 * OFF_LINE / BIN)
    votes = np.zeros((len(LEANS), count), np.int64)
    rows, points = np.nonzero((bins >= 0) & (bins < count))
    np.add.at(votes, (rows, bins[rows, points]), 1)
    # A wall that lies on the border of two bins has its points in both.
    votes[:, 1:] += votes[:, :-1].copy()
    lean, best = np.unravel_index(int(votes.argmax()), votes.shape)
    if votes[lean, best] < FEWEST_POINTS:
        return None
    rough = Line(expected.away - OFF_LINE + float(best) * BIN, float(headings[lean]))
    return _fit(x, y, rough)


def _fit(x: Floats, y: Floats, rough: Line) -> Line:
    """The line by least squares, from the points about a rough one."""
    line = rough
    for _ in range(2):
        cos, sin = math.cos(line.heading), math.sin(line.heading)
        away, left = x * cos + y * sin, y * cos - x * sin
        on = np.abs(away - line.away) < MEETS
        slope, offset = np.polyfit(left[on], away[on], 1).tolist()
        lean = -math.atan(slope)
        line = Line(offset * math.cos(lean), line.heading + lean)
    return line


def _states(beams: Floats, line: Line) -> NDArray[np.int64]:
    """What each `BIN` along the line is, from `ALONG` metres on the right to those on the left."""
    cos, sin = math.cos(line.heading), math.sin(line.heading)
    ahead, left = beams[:, 0] * cos + beams[:, 1] * sin, beams[:, 1] * cos - beams[:, 0] * sin
    angle = beams[:, 2] - line.heading
    cosine = np.cos(angle)
    expected = (line.away - ahead) / np.maximum(cosine, LEAST_COSINE)
    crossing = left + expected * np.sin(angle)
    told = (cosine > LEAST_COSINE) & (expected + BEYOND < beams[:, 4])
    told &= np.abs(crossing) < ALONG
    bins = np.floor((crossing[told] + ALONG) / BIN).astype(np.int64)
    more = beams[told, 3] - expected[told]
    meets = np.bincount(bins[np.abs(more) * cosine[told] < MEETS], minlength=_BINS)
    passes = np.bincount(bins[more > BEYOND], minlength=_BINS)
    states = np.full(_BINS, UNKNOWN)
    states[meets > passes] = MET
    states[(passes >= FEWEST_BEAMS) & (passes > 2 * meets)] = OPEN
    return states


def _middles(states: NDArray[np.int64], width: float) -> list[float]:
    """Metres to the left of the middles of openings as wide as a door, with wall on either side.

    Of what has no end in sight none is told: it may be the mouth of a corridor.
    """
    found = list[float]()
    for first, last in _runs(states):
        bounded = MET in states[max(0, first - 2) : first] and MET in states[last : last + 2]
        if bounded and -NARROWER < (last - first) * BIN - width < WIDER:
            found.append((first + last) / 2 * BIN - ALONG)
    return found


def _runs(states: NDArray[np.int64]) -> list[tuple[int, int]]:
    """Where bins that are open begin and end, first and one behind the last; one gap is bridged."""
    is_open = states == OPEN
    bridged = is_open.copy()
    bridged[1:-1] |= is_open[:-2] & is_open[2:] & (states[1:-1] != MET)
    edges = np.diff(np.concatenate([[0], bridged.astype(np.int64), [0]]))
    firsts, lasts = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return list(zip(firsts.tolist(), lasts.tolist(), strict=True))
