"""Words about simulated time that stands still for somebody; pure rules.

``wall`` is seconds of any monotonic clock, handed in.
"""

from __future__ import annotations

import math

from tca_bus import TcaError

SAY_AFTER = 5.0
"""Wall seconds of waiting that are worth a word."""

SAY_AGAIN = 60.0
"""Wall seconds until the next one."""


class StandstillError(TcaError, TimeoutError):
    """At ``tick``, on ``realm``, time has stood still for ``what`` for ``seconds``, in vain."""

    exit_code = 4

    def __init__(self, realm: str, tick: int, what: str, seconds: float) -> None:
        self.realm, self.tick, self.what, self.seconds = realm, tick, what, seconds
        super().__init__(
            f"realm {realm}: tick {tick} has waited for {what} for {seconds:g} s, in vain"
        )


class Standstill:
    """Follows what a tick waits for.

    Args:
        realm: of the robot that waits.
    """

    def __init__(self, realm: str) -> None:
        self._realm = realm
        self._what: str | None = None
        self._since = self._say_at = 0.0
        self._said_since: float | None = None

    def look(self, tick: int, what: str | None, wall: float, limit: float = math.inf) -> str | None:
        """Take in what a tick waits for, if for anything; gives a word that is to be said now.

        Raises:
            StandstillError: it has waited for that for more than ``limit`` wall seconds.
        """
        if what != self._what:
            self._what, self._since, self._say_at = what, wall, wall + SAY_AFTER
        if what is None:
            return None
        if wall - self._since > limit:
            raise StandstillError(self._realm, tick, what, limit)
        if wall < self._say_at:
            return None
        self._say_at = wall + SAY_AGAIN
        if self._said_since is None:
            self._said_since = self._since
        return f"realm {self._realm}: tick {tick} waits for {what}, {wall - self._since:.0f} s now"

    def end(self, tick: int, wall: float) -> str | None:
        """The tick goes on; gives a word if there was one that it waits."""
        since, self._what, self._said_since = self._said_since, None, None
        if since is None:
            return None
        return f"realm {self._realm}: tick {tick} goes on, after {wall - since:.0f} s"
