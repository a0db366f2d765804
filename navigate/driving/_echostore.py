"""Echoes that are kept for a few seconds after they were heard, one for each cell of the floor.

The cells lie in dead reckoning and are found by their coordinates modulo the side, so that the
store goes along with the robot, holds no more than its cells, and enters any number at once.
"""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from navigate.maps import Floats

CELL = 0.05
"""Metres along a side of a cell."""

SIDE = 48
"""Cells along a side of the store: what is 2.4 m apart shares a cell."""

Indices = NDArray[np.intp]

_NO_CELLS: Indices = np.empty(0, np.intp)


class EchoStore:
    """Spots with the time at which they were heard last.

    Args:
        seconds: for which a spot is kept.
        misses: readings past a spot that it takes to forget it: one may have glanced off.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_kept",)

    def __init__(self, *, seconds: float, misses: int) -> None:
        self._seconds, self._misses = seconds, misses
        self._spots: Floats = np.full((SIDE * SIDE, 2), np.inf)
        self._at: Floats = np.full(SIDE * SIDE, -np.inf)
        self._missed = np.zeros(SIDE * SIDE, dtype=np.intp)
        self._latest = -np.inf

    def enter(self, spots: Floats, time: float) -> None:
        """Keep ``spots`` (n, 2), metres, heard at ``time``; if that went back, nothing else."""
        if len(spots) == 0:
            return
        if time < self._latest:
            self._at[:] = -np.inf
        self._latest = time
        column, row = np.floor(spots * (1.0 / CELL)).astype(np.intp).T % SIDE
        cells = column * SIDE + row
        self._spots[cells], self._at[cells], self._missed[cells] = spots, time, 0

    def live(self, time: float) -> Indices:
        """The cells of what is kept still at ``time``."""
        if self._latest <= time - self._seconds:
            return _NO_CELLS
        return (self._at > time - self._seconds).nonzero()[0]

    def spots(self, cells: Indices) -> Floats:
        """Where the echoes of cells (n,) are, metres, shape (n, 2)."""
        return self._spots.take(cells, axis=0)

    def miss(self, cells: Indices) -> None:
        """Count a reading past each of some cells, and forget what was missed often."""
        if len(cells) == 0:
            return
        self._missed[cells] += 1
        self._at[cells[self._missed[cells] >= self._misses]] = -np.inf

    @property
    def _kept(self) -> Floats:
        cells = np.flatnonzero(np.isfinite(self._at))
        at, missed = self._at[cells], self._missed[cells]
        return np.column_stack([cells, self._spots[cells], at, missed])

    @_kept.setter
    def _kept(self, rows: Floats) -> None:
        cells = rows[:, 0].astype(np.intp)
        self._at[:] = -np.inf
        self._latest = float(rows[:, 3].max(initial=-np.inf))
        self._spots[cells], self._at[cells] = rows[:, 1:3], rows[:, 3]
        self._missed[cells] = rows[:, 4].astype(np.intp)
