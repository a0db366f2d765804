"""What became of every door: how often it was tried, stuck in, got through and given up."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True, slots=True)
class DoorTally:
    """The record of one door.

    ``passed`` and ``tries``: how often the robot got through, and how often it set out to.
    ``stuck``: how often it got stuck there, from which it has ``recovered`` when it got through
    in the same drive, and which it has ``given_up`` when it did not. ``shut``: how often the door
    was closed and stayed so.
    """

    passed: int = 0
    tries: int = 0
    stuck: int = 0
    recovered: int = 0
    given_up: int = 0
    shut: int = 0


class DoorLog:
    """The records of all doors, by their names."""

    STATE: ClassVar[tuple[str, ...]] = ("_counts",)

    def __init__(self) -> None:
        self._counts: dict[str, list[int]] = {}
        self._stuck_in: str | None = None

    @property
    def doors(self) -> dict[str, DoorTally]:
        """The record of each door that was tried."""
        return {door: DoorTally(*counts) for door, counts in self._counts.items()}

    def try_door(self, door: str) -> None:
        """The robot sets out to pass a door."""
        self._add(door, tries=1)

    def get_stuck(self, door: str) -> None:
        """It does not get on in the frame, however often until it is through or gives up."""
        if self._stuck_in != door:
            self.give_up()
            self._stuck_in = door
            self._add(door, stuck=1)

    def get_through(self, door: str) -> None:
        """It is through."""
        recovered = self._stuck_in == door
        self._add(door, passed=1, recovered=int(recovered))
        if recovered:
            self._stuck_in = None

    def find_shut(self, door: str) -> None:
        """It stands before a closed door."""
        self._add(door, shut=1)

    def give_up(self) -> None:
        """It will not try again for this goal."""
        if self._stuck_in is not None:
            self._add(self._stuck_in, given_up=1)
        self._stuck_in = None

    def _add(self, door: str, **more: int) -> None:
        counts = self._counts.setdefault(door, [0] * len(_NAMES))
        for name, count in more.items():
            counts[_NAMES.index(name)] += count


_NAMES = tuple(DoorTally.__dataclass_fields__)
