"""Says in the log that the robot is lost, and that it has found itself."""

from __future__ import annotations

import enum
import logging

from navigate.messages import Position
from navigate.navigator import Navigator
from navigate.service._sparing import Sparing
from navigate.wording import in_words, place_in_words

log = logging.getLogger(__name__)


class Whereabouts(enum.Enum):
    """Whether the robot knows where it is."""

    KNOWN = enum.auto()
    LOST = enum.auto()


class WhereaboutsLog:
    """A line when the robot gets lost, a line when it finds itself, and no flood of them.

    What is not said since it was said just before is said later, if it holds then.
    """

    def __init__(self) -> None:
        self._said = Whereabouts.KNOWN
        self._words = Sparing()

    def stepped(self, navigator: Navigator) -> None:
        """Look whether there is something to be said; to be called at every tick."""
        now = Whereabouts.LOST if navigator.localizer.lost else Whereabouts.KNOWN
        if now is self._said or not self._words.may_say(now):
            return
        self._said = now
        _say(now, navigator.position())


def _say(now: Whereabouts, position: Position) -> None:
    if now is Whereabouts.LOST:
        log.warning("the robot is %s", in_words(position))
    else:
        log.info("the robot has found itself at %s", place_in_words(position))
