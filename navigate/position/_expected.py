"""Expected sonar readings anywhere on a floor, from a table that fills as it is needed.

It holds, for each cell of 10 cm and each direction of 5 degrees, the range of a sonar cone with
the doors as open holes and with the doors shut. Filling a tile of cells is a few array operations
over the walls around; looking up costs a few nanoseconds a beam, so that hundreds of particles
fit into a control tick. Memory is used for what was filled.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from navigate.maps import Floats, Floor

CELL = 0.1
"""Metres along a side of a cell."""

TILE = 8
"""Cells along a side of a tile, which is filled at once."""

DIRECTIONS = 72
"""Directions in a full circle."""

REACH = 4.0
"""Metres beyond which a reading says only that there is nothing nearer."""

CODE = 0.016
"""Metres that a code of a byte stands for; none is 0, so that such a cell is not filled yet."""

GRAZING = 0.42
"""Cosine of the incidence from which an echo is not counted on any more (65 degrees)."""

FAR = 1e6
"""Stands for no hit: finite, so that it may be multiplied by a zero."""

Codes = NDArray[np.uint16]
"""Two ranges as codes: with open doors in the lower byte, with shut ones in the upper."""

Indices = NDArray[np.intp]
Singles = NDArray[np.float32]

SHUT_BITS, OPEN_MASK = 8, 0xFF


class ExpectedRanges:
    """The table for one floor; ``filled`` counts its tiles."""

    def __init__(self, floor: Floor) -> None:
        doors = np.array([door.segment() for door in floor.doors.values()]).reshape(-1, 4)
        self._walls, self._doors = _Lines(floor.walls), _Lines(doors)
        lows = np.array([(space.low.x, space.low.y) for space in floor.plan.spaces])
        highs = np.array([(space.high.x, space.high.y) for space in floor.plan.spaces])
        self._origin = lows.min(axis=0) - 1.0
        tiles = np.ceil((highs.max(axis=0) + 1.0 - self._origin) / (CELL * TILE)).astype(int)
        self._columns, self._rows = (tiles * TILE).tolist()
        # Not `zeros`, which the system hands out by and by: a robot would seem to leak for days.
        self._table: Codes = np.full((self._columns, self._rows, DIRECTIONS), 0, dtype=np.uint16)
        self.filled = 0

    def at(self, x: Floats, y: Floats, direction: Floats) -> tuple[Floats, Floats]:
        """Expected ranges of cones that start at points and look in directions.

        Args:
            x: metres, any shape.
            y: metres, same shape.
            direction: radians, same shape.

        Returns:
            Ranges with open doors and with shut doors, metres up to `REACH`, of that shape.
        """
        return ranges_of(self.codes(x, y, direction_of(direction)))

    def codes(self, x: Floats, y: Floats, look: Indices) -> Codes:
        """The same as codes, with directions as `direction_of` numbers them."""
        column = _cells(x, self._origin[0], self._columns)
        row = _cells(y, self._origin[1], self._rows)
        spots = column * self._rows
        spots += row
        places = spots * DIRECTIONS
        places += look
        found = self._table.ravel().take(places)
        if found.min(initial=1) == 0:
            self._fill_missing(spots)
            found = self._table.ravel().take(places)
        return np.asarray(found)

    def _fill_missing(self, spots: Indices) -> None:
        columns, rows = np.divmod(np.unique(spots), self._rows)
        tiles = np.unique(np.column_stack([columns, rows]) // TILE, axis=0)
        for column, row in (tiles * TILE).tolist():
            if self._table[column, row, 0] == 0:
                self._fill(column, row)

    def _fill(self, column: int, row: int) -> None:
        middles = (np.arange(TILE) + 0.5) * CELL
        xs = self._origin[0] + column * CELL + middles
        ys = self._origin[1] + row * CELL + middles
        shape = (TILE, TILE, DIRECTIONS)
        codes = self.panorama(xs, ys).reshape(shape)
        self._table[column : column + TILE, row : row + TILE] = codes
        self.filled += 1

    def panorama(self, xs: Floats, ys: Floats) -> Codes:
        """What cones in all directions read from the points of a small grid, past the table.

        Args:
            xs: metres, shape (n,), ascending.
            ys: metres, shape (m,), ascending.

        Returns:
            Codes (n * m, DIRECTIONS), x major.
        """
        open_doors = self._walls.ranges(xs, ys)
        shut_doors = np.minimum(open_doors, self._doors.ranges(xs, ys))
        return np.asarray(_codes(_cones(open_doors)) | _codes(_cones(shut_doors)) << SHUT_BITS)


def direction_of(angle: Floats) -> Indices:
    """The number of the direction nearest to an angle in radians, any shape."""
    turns = np.rint(angle * (DIRECTIONS / (2.0 * math.pi))).astype(np.intp)
    turns %= DIRECTIONS
    return turns


def ranges_of(codes: Codes) -> tuple[Floats, Floats]:
    """Ranges with open doors and with shut doors, metres."""
    opened, shut = codes & OPEN_MASK, codes >> SHUT_BITS
    return np.asarray(opened * CODE, np.float64), np.asarray(shut * CODE, np.float64)


def _cells(metres: Floats, origin: float, count: int) -> Indices:
    """The cells of coordinates; what is off the floor counts to its border."""
    cells = ((metres - origin) * (1.0 / CELL)).astype(np.intp)
    np.maximum(cells, 0, out=cells)
    return np.minimum(cells, count - 1, out=cells)


def _codes(ranges: Singles) -> Codes:
    return np.asarray(np.maximum(np.rint(ranges * (1.0 / CODE)), 1.0), dtype=np.uint16)


class _Lines:
    """Axis-parallel segments, apart by direction, so that rays meet them with few operations."""

    def __init__(self, segments: Floats) -> None:
        low = np.minimum(segments[:, :2], segments[:, 2:])
        high = np.maximum(segments[:, :2], segments[:, 2:])
        upright = (high[:, 0] - low[:, 0]) < (high[:, 1] - low[:, 1])
        self._upright = np.column_stack([low[:, 0], low[:, 1], high[:, 1]])[upright]
        self._level = np.column_stack([low[:, 1], low[:, 0], high[:, 0]])[~upright]

    def ranges(self, xs: Floats, ys: Floats) -> Singles:
        """Ranges (len(xs) * len(ys), DIRECTIONS) from every cell, x major, capped at REACH."""
        along = _hits(self._upright, xs, ys, _COS, _SIN)
        across = _hits(self._level, ys, xs, _SIN, _COS)
        best = np.minimum(along, across.transpose(1, 0, 2))
        return best.reshape(-1, DIRECTIONS)


_ANGLES = np.arange(DIRECTIONS) * (2.0 * math.pi / DIRECTIONS)
_COS: Singles = np.cos(_ANGLES).astype(np.float32)
_SIN: Singles = np.sin(_ANGLES).astype(np.float32)


def _hits(
    lines: Floats,
    across: Floats,
    along: Floats,
    toward: Singles,
    aside: Singles,
) -> Singles:
    """Ranges (len(across), len(along), DIRECTIONS) to lines at a coordinate ``across``."""
    near = _around(lines, across, along)
    out = np.full((len(across), len(along), DIRECTIONS), REACH, dtype=np.float32)
    facing = np.flatnonzero(np.abs(toward) > GRAZING)
    if len(near) == 0:
        return out
    lines32 = near.astype(np.float32)
    distance = lines32[None, None, :, 0] - across.astype(np.float32)[:, None, None]
    ranges = distance / toward[None, facing, None]
    ranges = np.where((ranges > 0.0) & (ranges < REACH), ranges, np.float32(FAR))
    meets = (
        along.astype(np.float32)[None, :, None, None]
        + (ranges * aside[None, facing, None])[:, None]
    )
    inside = (meets >= lines32[:, 1]) & (meets <= lines32[:, 2])
    hit = np.where(inside, ranges[:, None], np.float32(REACH)).min(axis=-1)
    out[:, :, facing] = np.minimum(hit, REACH)
    return out


def _around(lines: Floats, across: Floats, along: Floats) -> Floats:
    keep = (lines[:, 0] > across[0] - REACH) & (lines[:, 0] < across[-1] + REACH)
    keep &= (lines[:, 1] < along[-1] + REACH) & (lines[:, 2] > along[0] - REACH)
    return np.asarray(lines[keep])


def _cones(rays: Singles) -> Singles:
    """The nearest of each ray and its two neighbours on either side: a cone of 20 degrees."""
    best = rays
    for shift in (-2, -1, 1, 2):
        best = np.minimum(best, np.roll(rays, shift, axis=1))
    return best
