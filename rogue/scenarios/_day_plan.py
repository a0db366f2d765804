"""A day in the office, written down before it begins: who posts what, and what goes wrong.

The script is a pure function of its numbers and its seed. Times are seconds from the start.
"""

from __future__ import annotations

import enum
import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

SETTLING = 60.0
"""No errand is posted in the first minute."""

URGENT_SHARE, HOPELESS_SHARE, CANCELED_SHARE = 0.15, 0.10, 0.15
SILENT_SHARE = 0.2
"""One person in five does not answer."""

ORDINARY_HOURS = (1.5, 3.0)
URGENT_MINUTES = (25.0, 45.0)
HURRIED_SECONDS = 30
"""Nobody carries anything across the floor in this time."""

CHANGE_OF_MIND = (20.0, 90.0)
"""Seconds after which a user takes back what he asked for, unless he does when it is on its way."""

SHUT_MINUTES = (5.0, 15.0)
SHUT_DOORS = 6


class Kind(enum.StrEnum):
    """What a request of the script is meant to show."""

    ORDINARY = "ordinary"
    """It has hours."""
    URGENT = "urgent"
    """It has less than an hour."""
    HURRIED = "hurried"
    """Its deadline cannot be met."""
    UNREACHABLE = "unreachable"
    """The door of one of its rooms stays shut."""
    MISNAMED = "misnamed"
    """It names a room that does not exist."""
    CANCELED = "canceled"
    """Its user takes it back."""


@dataclass(frozen=True, slots=True)
class Post:
    """A request that a user posts; ``deadline`` is in seconds after ``at``."""

    at: float
    id: str
    kind: Kind
    user: str
    item: str
    pickup: str
    deliver: str
    deadline: float


@dataclass(frozen=True, slots=True)
class TakeBack:
    """A user's change of mind; ``item`` says what becomes of the item on the tray.

    Without ``at`` it comes when the item has been put on the tray.
    """

    at: float | None
    id: str
    item: str


@dataclass(frozen=True, slots=True)
class DoorMove:
    """Somebody opens or closes a door."""

    at: float
    room: str
    open: bool


DayEvent = Post | TakeBack | DoorMove


@dataclass(frozen=True, slots=True)
class DayPlan:
    """The whole script.

    ``silent`` are the rooms in which nobody answers; ``shut`` those whose doors are shut from the
    start to the end.
    """

    seed: int
    posts: tuple[Post, ...]
    back: tuple[TakeBack, ...]
    doors: tuple[DoorMove, ...]
    silent: frozenset[str]
    shut: frozenset[str]

    def events(self) -> list[tuple[float, DayEvent]]:
        """All that happens at a time of its own, in its order."""
        timed: list[tuple[float, DayEvent]] = [(post.at, post) for post in self.posts]
        timed += [(door.at, door) for door in self.doors]
        timed += [(back.at, back) for back in self.back if back.at is not None]
        return sorted(timed, key=lambda pair: pair[0])

    def taken_from_tray(self, user: str, item: str) -> TakeBack | None:
        """What is taken back when this item has been put on the tray."""
        waiting = {one.id: one for one in self.back if one.at is None}
        posts = (post for post in self.posts if (post.user, post.item) == (user, item))
        return next((waiting[post.id] for post in posts if post.id in waiting), None)

    def taken_back(self, request_id: str) -> TakeBack | None:
        """When a request is taken back, if it is."""
        return next((one for one in self.back if one.id == request_id), None)


@dataclass(frozen=True, slots=True)
class Staff:
    """Who may ask for what: the people with their rooms, the things with where they go."""

    rooms: Mapping[str, str]
    ends: Mapping[tuple[str, str], tuple[str, str]]


def make_day(
    staff: Staff, *, users: int, requests: int, hours: float, seed: int, rooms: Sequence[str]
) -> DayPlan:
    """Write a script.

    Args:
        staff: the people directory.
        users: how many different people post.
        requests: how many requests they post.
        hours: in which time.
        seed: of everything random.
        rooms: all rooms of the map.
    """
    rng = random.Random(f"day {seed}")
    people = sorted(staff.rooms)
    posting = rng.sample(people, users)
    quiet = rng.sample(posting, max(1, round(SILENT_SHARE * users)))
    free = sorted(set(rooms) - set(staff.rooms.values()) - _service_rooms(staff))
    shut = frozenset(rng.sample(free, 2))
    writer = _Writer(rng, staff, posting, sorted(shut), hours * 3600.0)
    posts = tuple(writer.posts(requests))
    back = tuple(writer.change_of_mind(post) for post in posts if post.kind is Kind.CANCELED)
    silent = frozenset(staff.rooms[user] for user in quiet)
    return DayPlan(seed, posts, back, tuple(writer.doors()), silent, shut)


def _service_rooms(staff: Staff) -> set[str]:
    return {room for ends in staff.ends.values() for room in ends}


@dataclass(slots=True)
class _Writer:
    rng: random.Random
    staff: Staff
    users: list[str]
    shut: list[str]
    seconds: float

    def posts(self, count: int) -> Iterator[Post]:
        """The requests in the order of their times; nobody asks for a thing twice at a time."""
        times = sorted(self.rng.uniform(SETTLING, self.seconds) for _ in range(count))
        kinds = self._kinds(count)
        pairs = self._pairs(count)
        for number, (at, kind, (user, item)) in enumerate(zip(times, kinds, pairs, strict=True)):
            yield self._post(round(at, 1), f"day-{number + 1:03d}", kind, user, item)

    def _kinds(self, count: int) -> list[Kind]:
        hopeless = [Kind.HURRIED, Kind.UNREACHABLE, Kind.MISNAMED]
        kinds = [Kind.URGENT] * round(URGENT_SHARE * count)
        kinds += [Kind.CANCELED] * round(CANCELED_SHARE * count)
        kinds += [hopeless[i % len(hopeless)] for i in range(round(HOPELESS_SHARE * count))]
        kinds += [Kind.ORDINARY] * (count - len(kinds))
        self.rng.shuffle(kinds)
        return kinds

    def _pairs(self, count: int) -> list[tuple[str, str]]:
        """Users and items: each user in turn, all of a user's things before one comes again."""
        stock = [pair for pair in sorted(self.staff.ends) if pair[0] in self.users]
        drawn: list[tuple[str, str]] = []
        while len(drawn) < count:
            self.rng.shuffle(stock)
            drawn += stock
        return drawn[:count]

    def _post(self, at: float, name: str, kind: Kind, user: str, item: str) -> Post:
        pickup, deliver = self.staff.ends[user, item]
        deadline = round(self.rng.uniform(*ORDINARY_HOURS) * 3600.0)
        match kind:
            case Kind.URGENT:
                deadline = round(self.rng.uniform(*URGENT_MINUTES) * 60.0)
            case Kind.HURRIED:
                deadline = HURRIED_SECONDS
            case Kind.UNREACHABLE if self.rng.random() < 0.5:
                pickup = self.rng.choice(self.shut)
            case Kind.UNREACHABLE:
                deliver = self.rng.choice(self.shut)
            case Kind.MISNAMED:
                deliver = "r-9999"
        return Post(at, name, kind, user, item, pickup, deliver, deadline)

    def change_of_mind(self, post: Post) -> TakeBack:
        """When a request is taken back, and what the user wants then."""
        item = self.rng.choice(("back", "deliver"))
        if self.rng.random() < 0.5:
            return TakeBack(None, post.id, item)
        return TakeBack(round(post.at + self.rng.uniform(*CHANGE_OF_MIND), 1), post.id, item)

    def doors(self) -> Iterator[DoorMove]:
        """Doors that are shut for good, and some that are shut for a while."""
        for room in self.shut:
            yield DoorMove(0.0, room, open=False)
        used = sorted({self.staff.rooms[user] for user in self.users})
        for room in self.rng.sample(used, min(SHUT_DOORS, len(used))):
            begin = self.rng.uniform(SETTLING, self.seconds)
            end = begin + self.rng.uniform(*SHUT_MINUTES) * 60.0
            yield DoorMove(round(begin, 1), room, open=False)
            yield DoorMove(round(end, 1), room, open=True)
