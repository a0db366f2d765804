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
"""Cells along a side of the grid, so that it reaches 3.2 m to either side of the robot."""

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

_BEAMS: Floats = np.linspace(-STRIPER_VIEW / 2, STRIPER_VIEW / 2, STRIPER_BEAMS)
_RAYS: Floats = np.array([-0.6, 0.0, 0.6]) * CONE_HALF
_STEPS: Floats = np.arange(0.05, REACH, CELL)


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

    def hear(self, pose: Pose, bearings: Floats, ranges: Floats) -> None:
        """Enter readings (k,) of sonars at ``bearings`` on a robot at ``pose``.

        One without an echo may have glanced off a wall, so it says little.
        """
        axes = pose[2] + bearings
        x = pose[0] + RING_RADIUS * np.cos(axes)
        y = pose[1] + RING_RADIUS * np.sin(axes)
        look = axes[:, None] + _RAYS
        cos, sin = np.cos(look), np.sin(look)
        heard = np.isfinite(ranges)
        short = np.where(heard, ranges - SHORT_OF_ECHO, REACH)
        passed = short[:, None, None] > _STEPS
        ray_x = x[:, None, None] + cos[..., None] * _STEPS
        ray_y = y[:, None, None] + sin[..., None] * _STEPS
        for which, gain in ((heard, FREE), (~heard, FAINT)):
            cells = np.repeat(passed & which[:, None, None], len(_RAYS), axis=1)
            self._add(ray_x[cells], ray_y[cells], gain)
        near = ranges < REACH
        hit = ranges[near, None]
        hit_x, hit_y = x[near, None] + cos[near] * hit, y[near, None] + sin[near] * hit
        self._add(hit_x.ravel(), hit_y.ravel(), OCCUPIED)
        np.clip(self._evidence, -MOST, MOST, out=self._evidence)

    def see(self, pose: Pose, beams: Floats) -> None:
        """Enter the beams (31,) of the light striper of a robot at ``pose``; none if empty.

        A beam is a line, so what it meets is where it ends, and what it passes is free.
        """
        if len(beams) != len(_BEAMS):
            return
        beams = beams[::BEAM_STEP]
        look = pose[2] + _BEAMS[::BEAM_STEP]
        cos, sin = np.cos(look)[:, None], np.sin(look)[:, None]
        x = pose[0] + STRIPER_AHEAD * math.cos(pose[2])
        y = pose[1] + STRIPER_AHEAD * math.sin(pose[2])
        passed = ((beams - CELL)[:, None] > _STEPS) & (_STEPS > STRIPER_NEAREST)
        self._add((x + cos * _STEPS)[passed], (y + sin * _STEPS)[passed], FREE)
        near = beams < STRIPER_FARTHEST
        met = beams[near, None]
        self._add((x + cos[near] * met).ravel(), (y + sin[near] * met).ravel(), OCCUPIED)
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

    def _add(self, x: Floats, y: Floats, gain: float) -> None:
        """Add evidence at points, once to each cell however many of them it holds."""
        columns, rows = self._cells(x, y)
        self._evidence[columns % SIDE, rows % SIDE] += gain

    @staticmethod
    def _cells(x: Floats, y: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        return np.floor(x / CELL).astype(np.int64), np.floor(y / CELL).astype(np.int64)
