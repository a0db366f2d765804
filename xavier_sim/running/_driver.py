"""The module that drives the robot: what it answered last, and whether it still answers."""

from __future__ import annotations

from xavier_sim.messages import Drive

DRIVER = "navigate"
"""The module that is expected to drive until another one does."""

SILENCE = 5
"""Control ticks without an answer after which the robot stops: 0.5 s."""

STOP = (0.0, 0.0)


class Driver:
    """The latest `Drive`, and whom it came from."""

    def __init__(self) -> None:
        self.name = DRIVER
        self.ignored = 0
        self._drive: Drive | None = None

    def hear(self, drive: Drive, sender: str, tick: int) -> bool:
        """Take in a command; false for one that answers no tick yet, or an older than the last.

        Whoever answers the latest tick drives: one that comes late with an older answer does not.
        """
        last = self._drive.tick if self._drive is not None else -1
        if not last <= drive.tick <= tick:
            self.ignored += 1
            return False
        self.name, self._drive = sender, drive
        return True

    def forget(self) -> None:
        """The driver is gone: what it said last does not count any more."""
        self._drive = None

    def answered(self, tick: int) -> bool:
        """Whether the sensors of ``tick`` have their answer."""
        return self._drive is not None and self._drive.tick == tick

    def busy(self, tick: int) -> bool:
        """Whether the answer to ``tick`` is there and says that the driver has a goal."""
        return self._drive is not None and self._drive.tick == tick and self._drive.busy

    def command(self, tick: int) -> tuple[float, float]:
        """Speed and turn rate for the step after ``tick``; a stop when the last one is too old."""
        if self._drive is None or tick - self._drive.tick > SILENCE:
            return STOP
        return self._drive.speed, self._drive.turn_rate
