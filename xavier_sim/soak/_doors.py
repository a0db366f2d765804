"""Doors that are opened and shut at random, as people do."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from xavier_sim.noise import restore_stream, stream, stream_state
from xavier_sim.profile import TICK


class DoorMove(NamedTuple):
    """A door by its own name, and how somebody wants it to stand."""

    door: str
    is_open: bool


class DoorKeeper:
    """Wants one door after another, in moments at random, to stand as chance has it.

    Any door stands shut for ``shut_share`` of the time, and is looked at ``moves_per_hour``
    times an hour, exponentially distributed.

    Args:
        doors: their names.
        shut_share: 0 to 1.
        moves_per_hour: of one door, 0 for doors that stay as they are.
        seed: of the moments and the states.
    """

    def __init__(
        self, doors: tuple[str, ...], *, shut_share: float, moves_per_hour: float, seed: int
    ) -> None:
        self._doors, self._shut_share = doors, shut_share
        self._random = stream(seed, "soak-doors")
        rate = moves_per_hour * len(doors) / 3600.0
        self._pause = 1.0 / rate if rate > 0.0 else math.inf
        self.next_tick = self._later(0)
        """When the next door is due, in ticks since the beginning; infinite for never."""

    def furnish(self) -> list[DoorMove]:
        """How each door is to stand to begin with."""
        return [self._wish(door) for door in self._doors]

    def due(self, tick: int) -> list[DoorMove]:
        """The moves that are due at a tick."""
        moves = list[DoorMove]()
        while tick >= self.next_tick:
            moves.append(self._wish(self._doors[int(self._random.integers(len(self._doors)))]))
            self.next_tick = self._later(self.next_tick)
        return moves

    def snapshot(self) -> dict[str, Any]:
        """What `restore` needs."""
        return {"next": self.next_tick, "random": stream_state(self._random)}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self.next_tick = state["next"]
        restore_stream(self._random, state["random"])

    def _wish(self, door: str) -> DoorMove:
        return DoorMove(door, bool(self._random.random() >= self._shut_share))

    def _later(self, tick: float) -> float:
        return tick + self._pause / TICK * float(self._random.standard_exponential())
