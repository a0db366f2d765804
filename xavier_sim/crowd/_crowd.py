"""Everybody and everything that moves besides the robots, with one random stream of its own."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import asdict
from typing import Any

from tca_bus import TcaError
from xavier_sim.body import Disc
from xavier_sim.crowd._cart import Cart, CartSpots
from xavier_sim.crowd._person import MARGIN, RADIUS, Person, Steering
from xavier_sim.crowd._walkways import NoSpotError, Point, Walkways
from xavier_sim.messages import FloorPlan
from xavier_sim.noise import restore_stream, stream, stream_state
from xavier_sim.profile import TICK

SPEEDS = (0.8, 1.4)
"""People like to walk between so many metres per second."""

LANES = (0.15, 0.85)

SIGHT = 4.0
"""People mind what is nearer than this, metres."""

CLOSE = 3.0
"""Whoever has a robot so near, in metres, decides at every tick, others every `SLOW` ticks."""

SLOW = 5

INSIDE = 1.0 / 3.0
"""Share of the people who may be in rooms, or on their way into one, at a time."""

DOOR_FREE = 3.0
"""Nobody sets out for a room when a robot is so near to its door, metres."""

AT_FIRST = 2.0
"""Metres between robots and people to begin with."""

TOUCH = 0.005
"""Metres by which somebody who overlooks a robot leans on it."""

TRIES = 1000


class NoRoomError(TcaError, ValueError):
    """The floor has no room for so many: ``what`` there should be ``count`` of."""

    exit_code = 2

    def __init__(self, what: str, count: int, placed: int) -> None:
        self.what, self.count, self.placed = what, count, placed
        super().__init__(f"{what} is {count}, expected no more than the {placed} that found room")


class Crowd:
    """People and carts on the open spaces of a floor; people visit rooms, too.

    Doors begin open.

    Args:
        plan: of the floor.
        seed: of all that they do.
        people: how many walk about.
        carts: how many stand about.
        robots: where the robots are to begin with.

    Raises:
        NoRoomError: they do not all fit on the floor.
    """

    def __init__(
        self, plan: FloorPlan, seed: int, *, people: int, carts: int, robots: Sequence[Disc]
    ) -> None:
        self._random = stream(seed, "crowd")
        self._walkways = Walkways(plan)
        self._steering = Steering(self._walkways, self._random, self._rooms_to_visit)
        self._robots: Sequence[Disc] = robots
        doors = [(door.at.x, door.at.y) for door in plan.doors]
        self._spots = CartSpots(self._walkways, doors, self._random)
        self.carts: list[Cart] = []
        self.people: list[Person] = []
        self.discs: list[Disc] = []
        for _ in range(carts):
            if not self._add_cart(robots):
                raise NoRoomError("carts", carts, len(self.carts))
        for _ in range(people):
            if not self._add_person(robots):
                raise NoRoomError("people", people, len(self.people))

    def step(self, tick: int, robots: Sequence[Disc], bumped: Collection[int]) -> None:
        """Let a control tick pass.

        Args:
            tick: that begins.
            robots: where they are now.
            bumped: numbers of the people whom a robot has run into since the last step.
        """
        self._robots = robots
        for number, person in enumerate(self.people):
            self._decide(number, person, tick, robots, number in bumped)
        for person in self.people:
            _move(person, robots)
        for cart in self.carts:
            self._pass_time(cart, robots)
        self._list()

    def see_door(self, door: int, *, is_open: bool) -> None:
        """Let people through a door of the plan, or not."""
        self._walkways.see_door(door, is_open=is_open)

    def snapshot(self) -> dict[str, Any]:
        """Everything that `restore` needs, as plain numbers."""
        return {
            "people": [asdict(person) for person in self.people],
            "carts": [asdict(cart) for cart in self.carts],
            "random": stream_state(self._random),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot; of more or fewer people or carts the first ones go back."""
        for number, kept in enumerate(state["people"][: len(self.people)]):
            way = [(x, y) for x, y in kept["way"]]
            self.people[number] = Person(**{**kept, "way": way})
        for number, kept in enumerate(state["carts"][: len(self.carts)]):
            self.carts[number] = Cart(**kept)
        restore_stream(self._random, state["random"])
        self._list()

    def _list(self) -> None:
        """Note where all are, people first: what others go by until the next step."""
        self.discs = [one.disc() for one in self.people] + [one.disc() for one in self.carts]

    def _decide(
        self, number: int, person: Person, tick: int, robots: Sequence[Disc], is_bumped: bool
    ) -> None:
        close = [robot for robot in robots if robot.gap(person.x, person.y, RADIUS) < CLOSE]
        if not (close or is_bumped or (tick + number) % SLOW == 0):
            return
        others = self._seen_by(number, person)
        if is_bumped and close:
            robot = min(close, key=lambda disc: disc.gap(person.x, person.y, RADIUS))
            self._steering.step_aside(person, robot, others)
        self._steering.decide(person, TICK if close else SLOW * TICK, others, close)

    def _rooms_to_visit(self) -> list[str]:
        """Rooms with an open door, nobody in them or on the way, and no robot near."""
        find = self._walkways.room_at
        taken = [
            find(one.x, one.y) or (find(*one.way[-1]) if one.way else None) for one in self.people
        ]
        if sum(room is not None for room in taken) + 1 > INSIDE * len(self.people):
            return []
        return [room for room in self._walkways.rooms if room not in taken and self._is_calm(room)]

    def _is_calm(self, room: str) -> bool:
        doors = self._walkways.doors_of(room)
        return bool(doors) and all(
            robot.gap(*door, 0.0) > DOOR_FREE for door in doors for robot in self._robots
        )

    def _seen_by(self, number: int, person: Person) -> list[Disc]:
        return [
            disc
            for other, disc in enumerate(self.discs)
            if other != number and disc.gap(person.x, person.y, RADIUS) < SIGHT
        ]

    def _pass_time(self, cart: Cart, robots: Sequence[Disc]) -> None:
        cart.stays -= TICK
        if cart.stays > 0.0 or any(disc.gap(cart.x, cart.y, 0.0) < SIGHT for disc in robots):
            return
        people = [person.disc() for person in self.people]
        others = [one.disc() for one in self.carts if one is not cart]
        spot = self._spots.find([*robots, *people], others)
        cart.stays = self._spots.stay()
        if spot is not None:
            cart.x, cart.y = spot

    def _add_cart(self, robots: Sequence[Disc]) -> bool:
        """Leave one standing; false when there is no room."""
        with suppress(NoSpotError):
            spot = self._spots.find(robots, [cart.disc() for cart in self.carts])
            if spot is not None:
                self.carts.append(Cart(*spot, self._spots.stay()))
                self._list()
                return True
        return False

    def _add_person(self, robots: Sequence[Disc]) -> bool:
        """Let one come in; false when there is no room."""
        with suppress(NoSpotError):
            for _ in range(TRIES):
                at = self._walkways.random_point(self._random, RADIUS + MARGIN)
                if self._is_free(at, robots):
                    speed = float(self._random.uniform(*SPEEDS))
                    lane = float(self._random.uniform(*LANES))
                    self.people.append(Person(*at, speed=speed, lane=lane))
                    self._list()
                    return True
        return False

    def _is_free(self, at: Point, robots: Sequence[Disc]) -> bool:
        away = all(disc.gap(*at, RADIUS) > AT_FIRST for disc in robots)
        return away and all(disc.gap(*at, RADIUS) > MARGIN for disc in self.discs)


def _move(person: Person, robots: Sequence[Disc]) -> None:
    """Go on for a tick; against a robot people go no farther than to touch it."""
    if person.vx == 0.0 and person.vy == 0.0:
        return
    dx, dy, share = person.vx * TICK, person.vy * TICK, 1.0
    for robot in robots:
        then = robot.gap(person.x + dx, person.y + dy, RADIUS)
        if then < -TOUCH and then < (now := robot.gap(person.x, person.y, RADIUS)):
            share = min(share, max(0.0, (now + TOUCH) / (now - then)))
    person.x, person.y = person.x + share * dx, person.y + share * dy
