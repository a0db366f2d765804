"""What is amiss, told once: a cause that comes again is counted, and told with its count later."""

from __future__ import annotations

import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass

PERIOD = 60.0
"""Seconds in which a cause is told at most once."""

MOST_CAUSES = 32
"""Different causes that are told in one period; the others count as one more cause."""

OTHERS = "other causes"


@dataclass(slots=True)
class _Told:
    at: float
    kept_back: int = 0


class Complaints:
    """Decides which complaints are told; ``now`` gives seconds of any monotonic clock."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now = now
        self._told: OrderedDict[str, _Told] = OrderedDict()

    def tell(self, cause: str, text: str) -> str | None:
        """The text to log, with how many like it were kept back before; None for not now."""
        now = self._now()
        self._forget(now)
        key = cause if cause in self._told or len(self._told) < MOST_CAUSES else OTHERS
        told = self._told.get(key)
        if told is not None and now - told.at < PERIOD:
            told.kept_back += 1
            return None
        self._told[key] = _Told(now)
        self._told.move_to_end(key)
        if told is None or not told.kept_back:
            return text
        return f"{text} (and {told.kept_back} more like it since the last time this was told)"

    def _forget(self, now: float) -> None:
        """Forget causes that have been quiet; one that was kept back is told once more first."""
        quiet = [k for k, t in self._told.items() if now - t.at >= PERIOD and not t.kept_back]
        for key in quiet:
            del self._told[key]
        late = [k for k, t in self._told.items() if now - t.at >= 10 * PERIOD]
        for key in late:
            del self._told[key]
