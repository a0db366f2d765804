"""Distances as the navigator tells them, and without it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from rogue_fakes import FakeModule

from navigate.messages import MOST_ROOMS, PlanRoutes, RouteTable
from rogue.distances import Distances

PLACES = {f"r-{n}": (3.0 * n, 4.0 * (n % 2)) for n in range(MOST_ROOMS + 10)}


@dataclass
class Navigator(FakeModule):
    """Answers how far it is between rooms: 100 m for each number, and no way to r-9."""

    asked: list[list[str]] = field(default_factory=list)

    def __post_init__(self) -> None:
        FakeModule.__init__(self)

    async def query(self, message: object) -> object:
        assert isinstance(message, PlanRoutes)
        assert message.as_built
        self.asked.append(message.rooms)
        numbers = [int(room[2:]) for room in message.rooms]
        metres = [[self._metres(one, other) for other in numbers] for one in numbers]
        return RouteTable(
            rooms=message.rooms, metres=metres, seconds=metres, from_here=[None] * len(numbers)
        )

    @staticmethod
    def _metres(one: int, other: int) -> float | None:
        return None if 9 in (one, other) else 100.0 * abs(one - other)


async def test_routes_are_asked_for_together_and_once():
    navigator = Navigator()
    distances = Distances(navigator)
    for _ in range(2):
        await distances.learn(["r-3", "r-1", "r-2"], PLACES)
    assert navigator.asked == [["r-1", "r-2", "r-3"]]
    assert distances("r-1", "r-3") == distances("r-3", "r-1") == 200.0


async def test_without_a_route_it_is_the_straight_line():
    navigator = Navigator()
    distances = Distances(navigator)
    for _ in range(2):
        await distances.learn(["r-1", "r-9"], PLACES)
    assert distances("r-1", "r-9") == 24.0
    assert len(navigator.asked) == 1


async def test_without_a_navigator_it_is_the_straight_line():
    distances = Distances(FakeModule())
    await distances.learn(["r-0", "r-1"], PLACES)
    assert distances("r-0", "r-1") == math.dist(PLACES["r-0"], PLACES["r-1"])
    assert distances("r-0", "r-nowhere") == 0.0


async def test_more_rooms_than_one_question_may_name_are_asked_for_in_pieces():
    navigator = Navigator()
    distances = Distances(navigator)
    await distances.learn(PLACES, PLACES)
    assert max(map(len, navigator.asked)) <= MOST_ROOMS
    assert distances("r-0", f"r-{MOST_ROOMS + 9}") == 100.0 * (MOST_ROOMS + 9)
