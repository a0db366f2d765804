"""Which sensor readings are of use: new, said again, late, useless, or from another time.

Pure rules. A reading is told by its tick and its time; what came before decides what it is.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from navigate.body import fault_of
from xavier_sim.messages import Sensors

LEAP = 60.0
"""Seconds by which the time may be ahead of what the ticks say: a robot that was started again."""

GAP = 5
"""Ticks without a reading that are worth a word: the robot has stopped meanwhile.

A counter that falls by more while time goes on is that of a robot that was started again.
"""

STILL = 3
"""Repetitions of a reading that nobody waits to have answered from which on it is no news.

A doubled one is repeated once; all the while that it is answered the robot drives blind.
"""

RUN = 3
"""Older readings in order, after which they are no stragglers: the time was set back."""


class Kind(enum.Enum):
    """What a reading is."""

    NEW = enum.auto()
    AGAIN = enum.auto()
    """The last one once more: its answer was lost."""
    LATE = enum.auto()
    """Overtaken by one that was sent after it."""
    USELESS = enum.auto()
    LEAPT = enum.auto()
    """New, but the time has jumped: what was timed before means nothing any more."""


@dataclass(frozen=True, slots=True)
class Judgement:
    """What a reading is, and the word about it that is worth a line in the log, if any."""

    kind: Kind
    word: str | None = None


class Intake:
    """Judges one reading after another."""

    def __init__(self) -> None:
        self._last: Sensors | None = None
        self._repeated = 0
        self._older: list[Sensors] = []
        self._is_another = False

    def expect_another(self) -> None:
        """The next reading is another robot's: nothing of it goes on from the last one."""
        self._last, self._is_another = None, True
        self._older.clear()

    def judge(self, sensors: Sensors) -> Judgement:
        """Say what a reading is; one that is taken in is what the next is compared with."""
        if fault := fault_of(sensors):
            return Judgement(Kind.USELESS, fault)
        last = self._last
        if last is None:
            return self._take(sensors, Kind.LEAPT if self._is_another else Kind.NEW)
        if (sensors.tick, sensors.time) == (last.tick, last.time):
            return self._judge_repeated(sensors)
        if sensors.time == last.time:
            return _still(sensors)
        if sensors.time < last.time:
            return self._judge_older(sensors, last)
        return self._judge_newer(sensors, last)

    def _judge_repeated(self, sensors: Sensors) -> Judgement:
        """Said again since its answer was lost, or by a robot whose clock and counter hang."""
        self._repeated += 1
        if self._repeated < STILL or sensors.lockstep:
            return Judgement(Kind.AGAIN)
        return _still(sensors)

    def _judge_newer(self, sensors: Sensors, last: Sensors) -> Judgement:
        ticks, seconds = sensors.tick - last.tick, sensors.time - last.time
        if ticks < -GAP:
            word = f"its counter fell from {last.tick}: the robot was started again"
            return self._take(sensors, Kind.LEAPT, word)
        if seconds > LEAP + max(0, ticks) * sensors.period:
            return self._take(sensors, Kind.LEAPT, f"time has jumped by {seconds:+.1f} s")
        if ticks > GAP:
            return self._take(sensors, Kind.NEW, f"{ticks - 1} readings before it are missing")
        return self._take(sensors, Kind.NEW)

    def _judge_older(self, sensors: Sensors, last: Sensors) -> Judgement:
        """A straggler, unless the world waits for its answer or more of them come in order."""
        if self._older and sensors.time <= self._older[-1].time:
            self._older.clear()
        self._older.append(sensors)
        if not sensors.lockstep and sensors.tick <= last.tick and len(self._older) < RUN:
            return Judgement(Kind.LATE, "it comes late")
        word = f"time has jumped by {sensors.time - last.time:+.1f} s"
        return self._take(sensors, Kind.LEAPT, word)

    def _take(self, sensors: Sensors, kind: Kind, word: str | None = None) -> Judgement:
        self._last, self._repeated, self._is_another = sensors, 0, False
        self._older.clear()
        return Judgement(kind, word)


def _still(sensors: Sensors) -> Judgement:
    return Judgement(Kind.USELESS, f"time stands still at {sensors.time:.1f} s")
