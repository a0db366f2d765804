"""Whether all who follow simulated time have taken what was told them; pure rules.

``wall`` is seconds of any monotonic clock, handed in.
"""

from __future__ import annotations

from collections.abc import Callable

from tca_bus import AwaitTime, Settled
from xavier_sim.running._simulated_time import HOLD_LIMIT

ASK_AGAIN = 0.5
"""Wall seconds after which a question is repeated that was not answered by all: it may be lost."""


class Quiet:
    """Time goes on when it was quiet: nothing has happened that not all have taken.

    What may set others to work is a time that came, news, a driver that began or ended, and that
    somebody waits for another time than before. Who has not answered for `HOLD_LIMIT` is not asked
    any more until it says something.
    """

    def __init__(self) -> None:
        self._said: dict[str, tuple[float | None, bool] | None] = {}
        self._names: dict[str, str] = {}
        self._number = 0
        self._stirred = False
        self._missing: set[str] = set()
        self._began = self._asked = float("-inf")

    def stir(self) -> None:
        """Something happened that others may have to do with."""
        self._stirred = True

    def hear(self, demand: AwaitTime) -> None:
        """A module said what it waits for; it stirs when that is something else than before."""
        said = (demand.until, demand.moves)
        if self._said.get(demand.incarnation) != said:
            self._stirred = True
        self._said[demand.incarnation] = said
        self._names[demand.incarnation] = demand.module

    def take(self, answer: Settled) -> None:
        """A module has taken all that came before a question, or says that it follows the time."""
        self._said.setdefault(answer.incarnation, None)
        self._names[answer.incarnation] = answer.module
        if answer.number == self._number:
            self._missing.discard(answer.incarnation)

    def question(self, wall: float, present: Callable[[str], bool]) -> int | None:
        """The number with which all are to be asked now; None when there is nothing to ask."""
        self._forget_absent(present)
        if self._stirred:
            self._stirred = False
            self._number += 1
            self._missing = set(self._said)
            self._began = self._asked = wall
        elif wall - self._asked < ASK_AGAIN:
            return None
        self._asked = wall
        return self._number if self._missing else None

    def give_up(self, wall: float) -> list[str]:
        """The modules that have not answered for too long, and are not waited for any more."""
        if not self._missing or wall - self._began < HOLD_LIMIT:
            return []
        late = sorted(self._names[one] for one in self._missing)
        for one in self._missing:
            del self._said[one], self._names[one]
        self._missing.clear()
        return late

    @property
    def is_quiet(self) -> bool:
        """Whether nothing has happened that not all have taken."""
        return not (self._stirred or self._missing)

    def _forget_absent(self, present: Callable[[str], bool]) -> None:
        for one in [one for one in self._said if not present(one)]:
            del self._said[one], self._names[one]
            self._missing.discard(one)
