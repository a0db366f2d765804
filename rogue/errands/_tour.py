"""Tours over errands: what a stop is, what a tour costs, and how good one is made."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Distance = Callable[[str, str], float]
"""Metres of the route from one room to another."""

Seconds = npt.NDArray[np.float64]

MISSED = 1e6
"""Seconds of detour that are taken to meet one more deadline."""


@dataclass(frozen=True, slots=True, kw_only=True)
class OpenErrand:
    """An errand as a tour sees it.

    Attributes:
        key: Names it; unique in a tour.
        pickup: Room where its item is.
        deliver: Room where the item goes.
        rank: Its priority; only differences between errands count.
        deadline: Latest time of its delivery, in seconds as ``now`` is.
        carried: The item is on the tray, so ``pickup`` is no stop any more.
    """

    key: str
    pickup: str
    deliver: str
    rank: float = 0.0
    deadline: float = math.inf
    carried: bool = False


class TravelError(ValueError):
    """A figure of `Travel` that makes no sense."""

    def __init__(self, name: str, value: float, expected: str) -> None:
        self.name, self.value, self.expected = name, value, expected
        super().__init__(f"{name} is {value}; expected {expected}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Travel:
    """How the robot gets about, and what its user wants of a tour.

    The cost of a tour is ``T + sum of w_e * C_e``: ``T`` is the seconds until the last stop is
    done, ``C_e`` those until errand ``e`` is delivered, and ``w_e = haste / number of errands +
    urgency * (rank_e - lowest rank)``. Equal ranks and no haste give the shortest way. An errand
    delivered after its deadline costs ``MISSED * (1 + w_e)`` more.

    Attributes:
        distance: Metres between two rooms.
        speed: Metres a second on the way.
        handling: Seconds at each stop.
        capacity: Items that the tray holds; None for any number.
        urgency: Weight of each rank above the lowest.
        haste: Weight of all errands together, besides that of their ranks.
    """

    distance: Distance
    speed: float = 0.4
    handling: float = 30.0
    capacity: int | None = None
    urgency: float = 0.05
    haste: float = 0.6

    def __post_init__(self) -> None:
        for name in ("speed", "capacity"):
            value = getattr(self, name)
            if value is not None and value <= 0:
                raise TravelError(name, value, "more than 0")
        for name in ("handling", "urgency", "haste"):
            if getattr(self, name) < 0.0:
                raise TravelError(name, getattr(self, name), "0 or more")


@dataclass(frozen=True, slots=True)
class Stop:
    """A place of a tour: ``done`` is when what is to be done there is done."""

    key: str
    room: str
    is_delivery: bool
    done: float


@dataclass(frozen=True, slots=True)
class Tour:
    """The order in which errands are served.

    Attributes:
        stops: In order.
        metres: Length of the way.
        cost: As `Travel` defines it, in seconds.
        late: Keys of the errands that are delivered after their deadlines.
        is_exact: Whether no tour costs less.
    """

    stops: tuple[Stop, ...]
    metres: float
    cost: float
    late: tuple[str, ...]
    is_exact: bool

    def completion(self, key: str) -> float:
        """When an errand is delivered; infinity for one that is not in the tour."""
        return next((s.done for s in self.stops if s.is_delivery and s.key == key), math.inf)


class Rooms:
    """Metres between rooms, asked once for each pair and kept as an array."""

    def __init__(self, distance: Distance) -> None:
        self._distance = distance
        self._index: dict[str, int] = {}
        self._metres: Seconds = np.zeros((16, 16))

    def metres(self, rooms: Sequence[str]) -> Seconds:
        """The square array of metres among ``rooms``."""
        for room in rooms:
            if room not in self._index:
                self._add(room)
        at = [self._index[room] for room in rooms]
        return self._metres[np.ix_(at, at)]

    def _add(self, room: str) -> None:
        new = len(self._index)
        if new == len(self._metres):
            self._metres = np.pad(self._metres, (0, new))
        for other, at in self._index.items():
            self._metres[new, at] = self._distance(room, other)
            self._metres[at, new] = self._distance(other, room)
        self._index[room] = new


@dataclass(frozen=True, slots=True)
class Setting:
    """The numbers of one problem: errands by index, stops by number.

    With ``k`` errands stop ``e`` is the pickup of errand ``e``, stop ``k + e`` its delivery, and
    ``2 * k`` is where the robot stands.

    Attributes:
        errands: In order of index.
        now: Seconds.
        metres: Between stops.
        seconds: Between stops, with the time at the second.
        weights: ``w_e`` by errand.
        deadlines: By errand, in seconds.
        capacity: Items that the tray holds; as many as there are errands for any number.
    """

    errands: tuple[OpenErrand, ...]
    now: float
    metres: Seconds
    seconds: Seconds
    weights: Seconds
    deadlines: Seconds
    capacity: int

    @staticmethod
    def of(
        errands: Iterable[OpenErrand],
        *,
        start: str | None,
        travel: Travel,
        now: float = 0.0,
        rooms: Rooms | None = None,
    ) -> Setting:
        """Measure a problem; without ``start`` the way to the first stop counts nothing."""
        listed = tuple(errands)
        places = [e.deliver if e.carried else e.pickup for e in listed] + [
            e.deliver for e in listed
        ]
        metres = (rooms or Rooms(travel.distance)).metres([*places, start or places[0]])
        if start is None:
            metres[-1, :] = 0.0
        ranks = np.array([e.rank for e in listed])
        return Setting(
            listed,
            now,
            metres,
            metres / travel.speed + travel.handling,
            travel.haste / len(listed) + travel.urgency * (ranks - ranks.min()),
            np.array([e.deadline for e in listed]),
            len(listed) if travel.capacity is None else travel.capacity,
        )

    def tour(self, order: Sequence[int], *, is_exact: bool) -> Tour:
        """The tour through stops in this order."""
        here, time, metres, cost = len(self.metres) - 1, self.now, 0.0, 0.0
        stops, late = [], []
        for stop in order:
            time += float(self.seconds[here, stop])
            metres += float(self.metres[here, stop])
            here = stop
            errand, is_delivery = self.errand(stop)
            one = self.errands[errand]
            room = one.deliver if is_delivery else one.pickup
            stops.append(Stop(one.key, room, is_delivery, time))
            if is_delivery:
                cost += float(self.weights[errand]) * (time - self.now)
                if time > one.deadline:
                    late.append(one.key)
                    cost += self.penalty(errand)
        return Tour(tuple(stops), metres, cost + time - self.now, tuple(late), is_exact)

    def errand(self, stop: int) -> tuple[int, bool]:
        """The errand of a stop, and whether it is its delivery."""
        is_delivery, errand = divmod(stop, len(self.errands))
        return errand, bool(is_delivery)

    def penalty(self, errand: int) -> float:
        """What it costs that an errand misses its deadline."""
        return MISSED * (1.0 + float(self.weights[errand]))


EMPTY = Tour((), 0.0, 0.0, (), is_exact=True)
"""The tour of no errands."""
