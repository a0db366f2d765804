"""Rays through a grid of cells, each of which names the segments in it: for numba to compile.

Cell by cell along the ray (Amanatides and Woo 1987), until something is met before the ray
leaves the cell. The formulas are those of `xavier_sim.sensors._rays`, in the same order.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from xavier_sim.sensors._caster import END_TOLERANCE, PARALLEL, Floats
from xavier_sim.sensors._compiling import compiled

NOTHING = -1
"""The index of no segment."""

Ray = tuple[float, float, float, float]
"""Start in metres, and unit vector."""


class Grid(NamedTuple):
    """The segments of a floor, and which of them are in each square cell.

    ``segments`` has shape (n, 5): start, vector and length, metres; ``on`` tells which are there.
    Cells are numbered row by row from the low corner; ``members[first[c]:first[c + 1]]`` are
    the segments in cell c, in rising order. ``reach`` is the longest ray.
    """

    segments: Floats
    on: NDArray[np.bool_]
    first: NDArray[np.int64]
    members: NDArray[np.int64]
    low_x: float
    low_y: float
    side: float
    columns: int
    rows: int
    reach: float


@compiled
def cast_rays(
    grid: Grid, origins: Floats, ux: Floats, uy: Floats, circles: Floats
) -> tuple[Floats, Floats]:
    """Distances and cosines of k rays, each of shape (k,).

    Args:
        grid: of the walls.
        origins: shape (k, 2), metres.
        ux: of the unit vectors, shape (k,).
        uy: likewise.
        circles: shape (m, 3), x, y and radius, metres.
    """
    hit, cosine = np.empty(len(ux)), np.empty(len(ux))
    for one in range(len(ux)):
        ray = (origins[one, 0], origins[one, 1], ux[one], uy[one])
        best, index = _walk(grid, ray)
        slant = 1.0 if index == NOTHING else abs(_cross(grid, index, ray)) / grid.segments[index, 4]
        best, slant = _rounds(ray, circles, best, slant)
        met = best <= grid.reach
        hit[one] = best if met else math.inf
        cosine[one] = slant if met else 1.0
    return hit, cosine


@compiled
def _walk(grid: Grid, ray: Ray) -> tuple[float, int]:
    """The nearest segment of a ray: distance and index, ``inf`` and `NOTHING` for none."""
    x, y, vx, vy = ray
    column = math.floor((x - grid.low_x) / grid.side)
    row = math.floor((y - grid.low_y) / grid.side)
    if not (0 <= column < grid.columns and 0 <= row < grid.rows):
        return _meet_all(grid, ray)
    best, index = math.inf, NOTHING
    ahead_x, ahead_y = 1 if vx > 0.0 else 0, 1 if vy > 0.0 else 0
    while 0 <= column < grid.columns and 0 <= row < grid.rows:
        cell = row * grid.columns + column
        for place in range(grid.first[cell], grid.first[cell + 1]):
            best, index = _closer(grid, ray, grid.members[place], best, index)
        edge_x = grid.low_x + (column + ahead_x) * grid.side
        edge_y = grid.low_y + (row + ahead_y) * grid.side
        out_x = (edge_x - x) / vx if vx != 0.0 else math.inf
        out_y = (edge_y - y) / vy if vy != 0.0 else math.inf
        if min(out_x, out_y) > grid.reach or best <= min(out_x, out_y):
            break
        if out_x < out_y:
            column += 2 * ahead_x - 1
        else:
            row += 2 * ahead_y - 1
    return best, index


@compiled
def _meet_all(grid: Grid, ray: Ray) -> tuple[float, int]:
    """The nearest segment of a ray that starts outside the grid."""
    best, index = math.inf, NOTHING
    for one in range(len(grid.on)):
        best, index = _closer(grid, ray, one, best, index)
    return best, index


@compiled
def _closer(grid: Grid, ray: Ray, one: int, best: float, index: int) -> tuple[float, int]:
    """The nearer one of segment ``one`` and what was met before; of two as near the first."""
    x, y, vx, vy = ray
    cross = _cross(grid, one, ray)
    if not (grid.on[one] and abs(cross) / grid.segments[one, 4] > PARALLEL):
        return best, index
    wx, wy = grid.segments[one, 0] - x, grid.segments[one, 1] - y
    dx, dy = grid.segments[one, 2], grid.segments[one, 3]
    distance = (wx * dy - wy * dx) / cross
    share = (wx * vy - wy * vx) / cross
    if not (0.0 <= distance <= best and -END_TOLERANCE <= share <= 1.0 + END_TOLERANCE):
        return best, index
    return (best, index) if distance == best and index < one else (distance, one)


@compiled
def _cross(grid: Grid, one: int, ray: Ray) -> float:
    """The ray's unit vector times the segment's vector."""
    dx, dy = grid.segments[one, 2], grid.segments[one, 3]
    cross: float = ray[2] * dy - ray[3] * dx
    return cross


@compiled
def _rounds(ray: Ray, circles: Floats, best: float, slant: float) -> tuple[float, float]:
    """The nearer one of the wall and all circles: distance and cosine."""
    x, y, vx, vy = ray
    for one in range(len(circles)):
        wx, wy, radius = circles[one, 0] - x, circles[one, 1] - y, circles[one, 2]
        middle = wx * vx + wy * vy
        outside = wx * wx + wy * wy - radius * radius
        half = middle * middle - outside
        if outside <= 0.0 and best > 0.0:
            best, slant = 0.0, 1.0
        elif outside > 0.0 and middle > 0.0 and half >= 0.0:
            chord = math.sqrt(half)
            if middle - chord < best:
                best, slant = middle - chord, chord / radius
    return best, slant
