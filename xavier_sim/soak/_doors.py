"""Doors that are opened and shut at random, as people do."""

from __future__ import annotations

import math
from typing import Any

from xavier_sim.noise import restore_stream, stream, stream_state
from xavier_sim.profile import TICK
from xavier_sim.world import World


class DoorKeeper:
    """Puts one door after another, in moments at random, into a state at random.

    Any door stands shut for ``shut_share`` of the time, and is looked at ``moves_per_hour``
    times an hour, exponentially distributed.

    Args:
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
        self._next = self._later(0)

    def furnish(self, world: World) -> None:
        """Open and shut all doors of a new world."""
        for door in self._doors:
            self._put(world, door)

    def tend(self, world: World) -> bool:
        """Do what is due at this tick; true when a door was moved."""
        moved = False
        while world.tick >= self._next:
            door = self._doors[int(self._random.integers(len(self._doors)))]
            moved |= self._put(world, door)
            self._next = self._later(self._next)
        return moved

    def snapshot(self) -> dict[str, Any]:
        """What `restore` needs."""
        return {"next": self._next, "random": stream_state(self._random)}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self._next = state["next"]
        restore_stream(self._random, state["random"])

    def _put(self, world: World, door: str) -> bool:
        wanted = bool(self._random.random() >= self._shut_share)
        before = world.open_doors[door]
        return wanted != before and world.set_door(door, is_open=wanted)[1] != before

    def _later(self, tick: float) -> float:
        return tick + self._pause / TICK * float(self._random.standard_exponential())
