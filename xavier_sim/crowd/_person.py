"""One person who walks the corridors: where to, whom they mind, and when they step aside."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from xavier_sim.body import Disc
from xavier_sim.crowd._walkways import Point, Walkways

RADIUS = 0.25
"""Metres from a person's middle to their shoulders."""

NOTICE = 2.5
"""A robot nearer than this, in metres, is seen, or overlooked until it is farther off."""

ATTENTIVE = 0.97
"""Share of the robots met that are seen."""

STOP = 1.0
"""Metres before a robot in the way at which a person stops who sees it."""

PATIENCE = (2.0, 8.0)
"""Seconds for which a person waits for a robot in the way before walking round it."""

LOOK_AHEAD = 1.2
"""Metres of the way ahead that are to be free."""

MARGIN = 0.08
"""Metres that people leave between themselves and what they pass."""

DETOURS = (0.0, 0.4, -0.4, 0.8, -0.8, 1.3, -1.3, 1.8, -1.8)
"""Radians off the straight way that are tried in turn."""

ASIDE = (0.0, 0.8, -0.8, 1.5, -1.5)
"""Radians off the way straight back that are tried by whoever was bumped into."""

ASIDE_SPEED, ASIDE_SECONDS = 0.5, 1.0

REACHED = 0.3
"""A waypoint counts as reached from so many metres off."""

CHAT = 0.5
"""Share of the walks at whose end somebody stands for a while."""

CHAT_SECONDS = (3.0, 60.0)

VISITS = 0.2
"""Share of the walks that lead into a room, where there is one to go to."""

VISIT_SECONDS = (20.0, 240.0)
"""How long somebody stays in a room."""

SHUT_IN = 5.0
"""Seconds after which somebody who found no way out looks again."""

HALTS_PER_SECOND = 1.0 / 90.0
"""How often somebody stops on their way: to read, to phone, to greet."""

HALT_SECONDS = 10.0
"""How long for, on average."""

STUCK_SECONDS, NEARER = 10.0, 0.1
"""After so long without coming so many metres nearer to their waypoint people go elsewhere."""


@dataclass
class Person:
    """Where somebody is, in metres and metres per second, and what they are about.

    ``speed`` is how fast they like to walk, ``lane`` where they cross openings, 0 to 1. They
    stand for ``pause`` more seconds; ``aside`` are seconds for which they still step aside.
    ``nearest`` is how near they have come to their waypoint, and ``stuck`` for how many seconds
    they have come no nearer. ``notices`` is None while no robot is near.
    """

    x: float
    y: float
    speed: float
    lane: float
    vx: float = 0.0
    vy: float = 0.0
    way: list[Point] = field(default_factory=list)
    pause: float = 0.0
    aside: float = 0.0
    nearest: float | None = None
    stuck: float = 0.0
    notices: bool | None = None
    patience: float = 0.0

    def disc(self) -> Disc:
        """What others see of them."""
        return Disc(self.x, self.y, RADIUS, person=True)


class Steering:
    """Decides where people go next.

    Args:
        walkways: where they can walk.
        random: the stream behind their whims.
        rooms: gives those that somebody may walk into now.
    """

    def __init__(
        self, walkways: Walkways, random: np.random.Generator, rooms: Callable[[], Sequence[str]]
    ) -> None:
        self._walkways, self._random, self._rooms = walkways, random, rooms

    def decide(
        self, person: Person, seconds: float, others: Sequence[Disc], robots: Sequence[Disc]
    ) -> None:
        """Choose the velocity that a person keeps for the next ``seconds``.

        Args:
            person: who decides.
            seconds: until they decide again.
            others: people and things within sight, less the person.
            robots: those within sight.
        """
        self._notice(person, robots)
        if person.aside > 0.0:
            person.aside -= seconds
            return
        person.vx = person.vy = 0.0
        if self._stands(person, seconds):
            return
        ahead = self._towards_goal(person)
        if ahead is None:
            return
        if person.notices and person.patience > 0.0 and _in_way(person, ahead, robots):
            person.patience -= seconds
            return
        minded = [*others, *robots] if person.notices else others
        self._walk(person, ahead, minded, seconds)

    def step_aside(self, person: Person, robot: Disc, others: Sequence[Disc]) -> None:
        """Let somebody whom a robot has bumped into make room, as far as there is any."""
        away = math.atan2(person.y - robot.y, person.x - robot.x)
        person.notices, person.pause, person.aside = True, 0.0, ASIDE_SECONDS
        person.vx = person.vy = 0.0
        for heading in self._free_headings(person, away, ASIDE, others, ASIDE_SPEED):
            person.vx = ASIDE_SPEED * math.cos(heading)
            person.vy = ASIDE_SPEED * math.sin(heading)
            return

    def _notice(self, person: Person, robots: Sequence[Disc]) -> None:
        if not any(robot.gap(person.x, person.y, RADIUS) < NOTICE for robot in robots):
            person.notices = None
        elif person.notices is None:
            person.notices = bool(self._random.random() < ATTENTIVE)
            person.patience = float(self._random.uniform(*PATIENCE))

    def _stands(self, person: Person, seconds: float) -> bool:
        if person.pause <= 0.0 and self._random.random() < seconds * HALTS_PER_SECOND:
            person.pause = float(self._random.exponential(HALT_SECONDS))
        if person.pause <= 0.0:
            return False
        person.pause -= seconds
        return True

    def _towards_goal(self, person: Person) -> float | None:
        """The heading of the next waypoint; None for who has just arrived, or finds no way."""
        room = self._walkways.room_at(person.x, person.y)
        while person.way and math.dist(person.way[0], (person.x, person.y)) < REACHED:
            reached = person.way.pop(0)
            person.nearest, person.stuck = None, 0.0
            if not person.way and (stay := self._stay_at(reached)):
                person.pause = stay
                return None
        if not person.way:
            goal = self._choose_goal(room)
            here = (person.x, person.y)
            person.way = self._walkways.way(here, goal, lane=person.lane, radius=RADIUS + REACHED)
        if not person.way:
            person.pause = SHUT_IN if room else 0.0
            return None
        x, y = person.way[0]
        return math.atan2(y - person.y, x - person.x)

    def _stay_at(self, goal: Point) -> float:
        """For how many seconds to stand at the end of a walk.

        By its goal, not by where the person stands: near a goal in a doorway that may be the room.
        """
        if self._walkways.room_at(*goal):
            return float(self._random.uniform(*VISIT_SECONDS))
        chats = self._random.random() < CHAT
        return float(self._random.uniform(*CHAT_SECONDS)) if chats else 0.0

    def _choose_goal(self, room: str | None) -> Point:
        """Where to go next: from a room back to the others, from there now and then into one."""
        if room is None and self._random.random() < VISITS and (rooms := self._rooms()):
            chosen = rooms[int(self._random.integers(len(rooms)))]
            inside = self._walkways.room_point(self._random, chosen, RADIUS + MARGIN)
            if inside is not None:
                return inside
        return self._walkways.random_point(self._random, RADIUS + MARGIN)

    def _walk(self, person: Person, ahead: float, minded: Sequence[Disc], seconds: float) -> None:
        x, y = person.way[0]
        away = math.hypot(x - person.x, y - person.y)
        if self._gets_nowhere(person, away, seconds):
            return
        # Who decided but twice a second would go past a waypoint and back for ever.
        speed, reach = min(person.speed, away / seconds), min(LOOK_AHEAD, away)
        for heading in self._free_headings(person, ahead, DETOURS, minded, reach):
            person.vx, person.vy = speed * math.cos(heading), speed * math.sin(heading)
            return

    @staticmethod
    def _gets_nowhere(person: Person, away: float, seconds: float) -> bool:
        """Whether to give a way up: round others somebody may get behind a wall and stay there."""
        if person.nearest is None or away < person.nearest - NEARER:
            person.nearest, person.stuck = away, 0.0
            return False
        person.stuck += seconds
        if person.stuck <= STUCK_SECONDS:
            return False
        person.way, person.nearest, person.stuck = [], None, 0.0
        return True

    def _free_headings(
        self,
        person: Person,
        ahead: float,
        turns: Sequence[float],
        minded: Sequence[Disc],
        reach: float,
    ) -> Iterator[float]:
        for turn in turns:
            ux, uy = math.cos(ahead + turn), math.sin(ahead + turn)
            has_room = all(
                self._walkways.has_room(person.x + step * ux, person.y + step * uy, RADIUS)
                for step in (min(reach, RADIUS), min(reach, 3.0 * RADIUS))
            )
            if has_room and _is_free(person, ux, uy, reach, minded):
                yield ahead + turn


def _in_way(person: Person, heading: float, robots: Sequence[Disc]) -> bool:
    """Whether a robot is near and ahead."""
    ux, uy = math.cos(heading), math.sin(heading)
    for robot in robots:
        dx, dy = robot.x - person.x, robot.y - person.y
        is_ahead = dx * ux + dy * uy > 0.5 * math.hypot(dx, dy)
        if is_ahead and robot.gap(person.x, person.y, RADIUS) < STOP:
            return True
    return False


def _is_free(person: Person, ux: float, uy: float, reach: float, minded: Sequence[Disc]) -> bool:
    """Whether a person can go so far along a unit vector without running into anything."""
    for disc in minded:
        dx, dy = disc.x - person.x, disc.y - person.y
        along = min(dx * ux + dy * uy, reach)
        if along <= 0.0:
            continue
        across = math.hypot(dx - along * ux, dy - along * uy)
        if across < disc.radius + RADIUS + MARGIN:
            return False
    return True
