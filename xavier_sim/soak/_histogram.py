"""A distribution in bounded memory: counts in bins of equal width, and the greatest value."""

from __future__ import annotations

from typing import Any


class Histogram:
    """Counts values from 0 up; what lies beyond the last bin is counted in it.

    Args:
        width: of a bin, in the unit of the values.
        bins: how many.
    """

    def __init__(self, *, width: float, bins: int) -> None:
        self._width = width
        self._counts = [0] * bins
        self.most = 0.0

    def add(self, value: float) -> None:
        """Count a value."""
        index = min(int(value / self._width), len(self._counts) - 1)
        self._counts[index] += 1
        self.most = max(self.most, value)

    @property
    def total(self) -> int:
        """How many values were counted."""
        return sum(self._counts)

    def quantile(self, share: float) -> float | None:
        """The upper end of the bin below which ``share`` of the values lie, None without values."""
        wanted, seen = share * self.total, 0
        for index, count in enumerate(self._counts):
            seen += count
            if count and seen >= wanted:
                return min((index + 1) * self._width, self.most)
        return None

    def shares(self) -> list[tuple[float, float]]:
        """The cumulative distribution: upper ends of filled bins and the share up to there."""
        total, seen, points = max(self.total, 1), 0, list[tuple[float, float]]()
        for index, count in enumerate(self._counts):
            seen += count
            if count:
                points.append(((index + 1) * self._width, seen / total))
        return points

    def add_all(self, other: Histogram) -> None:
        """Count all that another one with the same bins has counted."""
        pairs = zip(self._counts, other._counts, strict=True)
        self._counts = [mine + theirs for mine, theirs in pairs]
        self.most = max(self.most, other.most)

    def snapshot(self) -> dict[str, Any]:
        """What `restore` needs."""
        return {"counts": list(self._counts), "most": self.most}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self._counts, self.most = list(state["counts"]), state["most"]
