"""How long and how often the robot tries."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Patience:
    """How often and how long a procedure tries before it gives up.

    ``asks`` is how often a question is put while nobody answers, each time for
    ``answer_within`` seconds on the module's clock; ``tries`` how often the robot drives to a
    room before the planner is told that it is elsewhere (Haigh & Veloso 1998).

    Where nobody is in, or the way is blocked, the errand is put off for ``later`` seconds, and so
    ``returns`` times. An errand for which the robot ended up in another room ``wrong_arrivals``
    times, or found the world to be other than planned as often, is given up. A battery that is low
    is charged up to ``charge``, 0 to 1.
    """

    asks: int = 3
    tries: int = 3
    answer_within: float = 60.0
    later: float = 600.0
    returns: int = 2
    wrong_arrivals: int = 3
    charge: float = 0.8
