"""A grid of what was heard around the robot lately: free, occupied, or unknown.

It lies in the robot's dead reckoning and goes along with it, so it is exact for as far as
odometry is, some metres. After Moravec & Elfes' certainty grids (1985), with the cells of a cone
reduced to a few of its rays.
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from navigate.body._odometry import Pose
from navigate.body._sonarring import CONE_HALF, RING_RADIUS
from navigate.maps import Floats
from xavier_sim.messages import (
    STRIPER_AHEAD,
    STRIPER_BEAMS,
    STRIPER_FARTHEST,
    STRIPER_NEAREST,
    STRIPER_VIEW,
)

CELL = 0.1
"""Metres along a side of a cell."""

SIDE = 64
"""Cells along a side of the grid, a power of two: it reaches 3.2 m to either side of the robot."""

_WITHIN = SIDE - 1

REACH = 2.9
"""Metres from the ring within which echoes are entered."""

FREE, OCCUPIED = -0.4, 0.9
"""What a cell gains by a ray that passes, and by an echo: log odds."""

FAINT = -0.1
"""What a cell gains by a ray that passes without an echo."""

MOST = 3.0
SHORT_OF_ECHO = 0.25
"""Metres before an echo from which a cone's cells may be the thing itself."""

BEAM_STEP = 3
"""One of so many beams of the striper is entered: three degrees are a cell at 2 m."""

APART = 0.85
"""Metres from which the rays of a cone lie in different cells."""

_STEPS: Floats = np.arange(0.05, REACH, CELL)
_Rays = tuple[Floats, Floats, Floats]
"""Where they begin, x and y, and in which directions they go."""

_Fan = tuple[Floats, Floats, Floats]
"""Points ahead and to the left of where a ray begins, and how far out they are."""


def _fan(rays: Floats, steps: Floats, *, apart: float) -> _Fan:
    """Points on rays, and how far out they are; on those but the middle one from ``apart`` on."""
    look, out = (part.ravel() for part in np.meshgrid(rays, steps, indexing="ij"))
    wanted = (look == 0.0) | (out >= apart)
    look, out = look[wanted], out[wanted]
    return out * np.cos(look), out * np.sin(look), out


_RAYS: Floats = np.array([-0.6, 0.0, 0.6]) * CONE_HALF
_CONE = _fan(_RAYS, _STEPS, apart=APART)
_BEAMS: Floats = np.linspace(-STRIPER_VIEW / 2, STRIPER_VIEW / 2, STRIPER_BEAMS)[::BEAM_STEP]
_BEAM = _fan(np.zeros(1), _STEPS[_STEPS > STRIPER_NEAREST], apart=0.0)


class LocalGrid:
    """Evidence (64, 64) in log odds; a cell is found by its coordinates modulo the side."""

    STATE: ClassVar[tuple[str, ...]] = ("_evidence", "_corner")

    def __init__(self) -> None:
        self._evidence: Floats = np.zeros((SIDE, SIDE))
        self._corner = (-SIDE // 2, -SIDE // 2)

    def clear(self) -> None:
        """Forget everything: the robot was carried somewhere else."""
        self._evidence[:] = 0.0

    def follow(self, x: float, y: float) -> None:
        """Keep the robot, in dead reckoning, in the middle, and forget what is out of reach."""
        corner = (math.floor(x / CELL) - SIDE // 2, math.floor(y / CELL) - SIDE // 2)
        for axis in (0, 1):
            moved = corner[axis] - self._corner[axis]
            if moved:
                first = self._corner[axis] if moved > 0 else corner[axis]
                stale = np.arange(first, first + min(abs(moved), SIDE)) % SIDE
                self._evidence[(stale,) if axis == 0 else (slice(None), stale)] = 0.0
        self._corner = corner

    def hear(self, poses: Pose | Floats, bearings: Floats, ranges: Floats) -> None:
        """Enter readings (k,) of sonars at ``bearings`` on a robot at one pose, or at k of them.

        One without an echo may have glanced off a wall, so it says little.
        """
        mount = np.broadcast_to(np.asarray(poses), (len(ranges), 3))
        look = mount[:, 2] + bearings
        x = mount[:, 0] + RING_RADIUS * np.cos(look)
        y = mount[:, 1] + RING_RADIUS * np.sin(look)
        heard = np.isfinite(ranges)
        short = np.where(heard, ranges - SHORT_OF_ECHO, REACH)
        self._pass((x, y, look), short, np.where(heard, FREE, FAINT), _CONE)
        near = ranges < REACH
        if near.any():
            rays = look[near, None] + _RAYS
            self._meet((x[near, None], y[near, None], rays), ranges[near, None])
        np.clip(self._evidence, -MOST, MOST, out=self._evidence)

    def see(self, poses: Pose | Floats, beams: Floats) -> None:
        """Enter the beams (31,) of the light striper of a robot at a pose, or n times as many.

        A beam is a line, so what it meets is where it ends, and what it passes is free. Without
        beams nothing is entered.
        """
        if beams.size == 0 or beams.shape[-1] != STRIPER_BEAMS:
            return
        taken = np.atleast_2d(beams)[:, ::BEAM_STEP]
        mount = np.broadcast_to(np.asarray(poses), (len(taken), 3))[:, :, None]
        look = (mount[:, 2] + _BEAMS).ravel()
        x, y = mount[:, 0] + np.zeros(len(_BEAMS)), mount[:, 1] + np.zeros(len(_BEAMS))
        x = (x + STRIPER_AHEAD * np.cos(mount[:, 2])).ravel()
        y = (y + STRIPER_AHEAD * np.sin(mount[:, 2])).ravel()
        ranges = taken.ravel()
        self._pass((x, y, look), ranges - CELL, np.full(len(x), FREE), _BEAM)
        near = ranges < STRIPER_FARTHEST
        self._meet((x[near], y[near], look[near]), ranges[near])
        np.clip(self._evidence, -MOST, MOST, out=self._evidence)

    def evidence(self, x: Floats, y: Floats) -> Floats:
        """The evidence at points, any shape, for what is there: above zero for something."""
        columns, rows = self._cells(x, y)
        inside = (columns >= self._corner[0]) & (columns < self._corner[0] + SIDE)
        inside &= (rows >= self._corner[1]) & (rows < self._corner[1] + SIDE)
        return np.where(inside, self._evidence[columns % SIDE, rows % SIDE], 0.0)

    def occupied(self) -> Floats:
        """The middles of the cells in which something was heard, shape (n, 2), metres."""
        found = np.argwhere(self._evidence > OCCUPIED / 2)
        corner = np.array(self._corner)
        return np.asarray((corner + (found - corner) % SIDE + 0.5) * CELL)

    def _pass(self, rays: _Rays, short: Floats, gains: Floats, fan: _Fan) -> None:
        """Enter what the fans on k rays pass up to so many metres."""
        (x, y, look), (ahead, left, out) = rays, fan
        cos, sin = np.cos(look)[:, None], np.sin(look)[:, None]
        weights = (short[:, None] > out) * gains[:, None]
        self._add(
            x[:, None] + cos * ahead - sin * left, y[:, None] + sin * ahead + cos * left, weights
        )

    def _meet(self, rays: _Rays, ranges: Floats) -> None:
        """Enter what rays meet at their ends."""
        x, y, look = rays
        ends = (x + ranges * np.cos(look), y + ranges * np.sin(look))
        self._add(*ends, np.full(ends[0].shape, OCCUPIED))

    def _add(self, x: Floats, y: Floats, gains: Floats) -> None:
        """Add evidence at points within the grid."""
        columns, rows = self._cells(x, y)
        off = (columns - self._corner[0]) | (rows - self._corner[1])
        gains = np.where(off & ~_WITHIN, 0.0, gains)
        cells = (columns & _WITHIN) * SIDE + (rows & _WITHIN)
        added = np.bincount(cells.ravel(), gains.ravel(), SIDE * SIDE)
        self._evidence += added.reshape(SIDE, SIDE)

    @staticmethod
    def _cells(x: Floats, y: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        return np.floor(x / CELL).astype(np.int64), np.floor(y / CELL).astype(np.int64)
