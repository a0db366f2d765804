"""How long and how often the robot tries."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Patience:
    """How often and how long a procedure tries before it gives up.

    ``asks`` is how often a question is put while nobody answers, each time for
    ``answer_within`` seconds on the module's clock; ``tries`` how often the robot drives to a
    room before the planner is told that it is elsewhere (Haigh & Veloso 1998).
    """

    asks: int = 3
    tries: int = 3
    blocked_tries: int = 5
    pause: float = 60.0
    answer_within: float = 60.0
