"""When the next control tick may come: in lockstep with the driver, or with the wall clock."""

from __future__ import annotations

import math

from tca_bus import ConfigError
from xavier_sim.profile import TICK

ANSWER_PATIENCE = 0.3
"""Wall seconds after which sensors that nobody answered are sent again."""

IDLE_REPEAT = 1.0
"""Wall seconds after which sensors are sent again while time stands still."""

ALONE_PAUSE = TICK / 25
"""Wall seconds per tick while nobody drives: waiting modules see time pass 25 times as fast, and
a driver that is being restarted does not miss hours."""

LATE = 1.0
"""When the paced world is so many wall seconds behind, it gives up catching up."""


def may_tick(*, driven: bool, answered: bool, busy: bool, moving: bool, holding: bool) -> bool:
    """Whether simulated time may move by a tick in lockstep.

    Args:
        driven: a driver is there.
        answered: it has answered the sensors of the current tick.
        busy: it has a goal.
        moving: some module waits actively for a time to come.
        holding: some module's time has come, and it has not yet said what it waits for next.
    """
    if holding or (driven and not answered):
        return False
    return moving or (driven and busy)


class Metronome:
    """Wall times of the ticks at a fixed speed; no tick is left out.

    Args:
        speed: simulated seconds per wall second.
        wall: the time now, seconds of a monotonic clock.
    """

    def __init__(self, speed: float, wall: float) -> None:
        self._period = TICK / speed
        self._next = wall + self._period

    def pause(self, wall: float) -> float:
        """Wall seconds to wait before the next tick; counts that tick as done."""
        if wall - self._next > LATE:
            self._next = wall
        wait = max(0.0, self._next - wall)
        self._next += self._period
        return wait


def parse_speed(text: str) -> float | None:
    """The speed that ``--speed`` names; None for ``max``, lockstep.

    Raises:
        ConfigError: it is neither ``max`` nor a positive number.
    """
    if text == "max":
        return None
    try:
        speed = float(text)
    except ValueError:
        speed = math.nan
    if not (math.isfinite(speed) and speed > 0.0):
        raise ConfigError("--speed", text, "a number above 0, or max")
    return speed
