"""Which robot is followed, where more than one sends readings."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

GONE_SECONDS = 5.0
"""Wall seconds of silence after which another robot that sends readings is followed instead."""

MOST_NAMED = 16
"""Modules whose readings are left aside with a word each; of more there is none."""


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether a reading is of the robot that is followed, and a word for the log, if any.

    ``other`` says that it is so from now on: what came before was another robot.
    """

    taken: bool
    other: bool = False
    word: str | None = None


class Followed:
    """Follows the module whose readings come first, until it is gone.

    It is gone when it was on the bus and has left it, or has been silent for `GONE_SECONDS`. One
    that is started again under its name is the same robot.

    Args:
        is_present: whether a module of this name is on the bus.
    """

    def __init__(self, is_present: Callable[[str], bool]) -> None:
        self._is_present = is_present
        self.name: str | None = None
        self._heard_at = 0.0
        self._was_present = False
        self._left_aside: set[str] = set()

    def judge(self, sender: str, now: float) -> Verdict:
        """Say whether to take in a reading of ``sender`` that comes at ``now``, in wall seconds."""
        before = self.name
        if sender == before:
            self._heard_at = now
            return Verdict(taken=True)
        if before is not None and not self._is_gone(before, now):
            return Verdict(taken=False, word=self._aside(sender, before))
        self._follow(sender, now)
        if before is None:
            return Verdict(taken=True)
        word = f"follows the robot {sender} from now on: {before} is gone"
        return Verdict(taken=True, other=True, word=word)

    def _follow(self, sender: str, now: float) -> None:
        self.name, self._heard_at = sender, now
        self._was_present = self._is_present(sender)
        self._left_aside.clear()

    def _is_gone(self, name: str, now: float) -> bool:
        # One without a liveliness token, or whose token is still under way, has not left.
        if self._is_present(name):
            self._was_present = True
        elif self._was_present:
            return True
        return now - self._heard_at >= GONE_SECONDS

    def _aside(self, sender: str, name: str) -> str | None:
        """A word about a second robot, the first time that it is heard beside this one."""
        if sender in self._left_aside or len(self._left_aside) >= MOST_NAMED:
            return None
        self._left_aside.add(sender)
        return f"two robots send readings: follows {name}, and leaves those of {sender} aside"
