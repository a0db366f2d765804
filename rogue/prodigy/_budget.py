"""A bound on how many values are tried, so that no single question runs away."""

from __future__ import annotations

from collections.abc import Callable

from rogue.prodigy._errors import TooManyValuesError

_TICKS = 512
"""Values tried between two looks at the clock."""


class OutOfTimeError(Exception):
    """The time of a search is up in the midst of a step; caught where a search is run."""


class Budget:
    """Counts the values tried in one step of a search, and watches the clock meanwhile.

    Args:
        most: Values that may be tried in one step.
        is_late: Says whether the time is up.
    """

    __slots__ = ("_is_late", "_left", "_until_look", "most")

    def __init__(self, most: int, is_late: Callable[[], bool] = lambda: False) -> None:
        self.most = most
        self._is_late = is_late
        self._left = most
        self._until_look = _TICKS

    def renew(self) -> None:
        """Begin another step."""
        self._left = self.most

    def spend(self, count: int = 1) -> None:
        """Count ``count`` values.

        Raises:
            TooManyValuesError: If it is one too many.
            OutOfTimeError: If the time is up.
        """
        self._left -= count
        if self._left < 0:
            raise TooManyValuesError(self.most)
        self._until_look -= count
        if self._until_look <= 0:
            self._until_look = _TICKS
            if self._is_late():
                raise OutOfTimeError
