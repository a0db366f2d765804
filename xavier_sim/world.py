"""The simulated world: a pure function of floor, seed and the commands per tick.

No clock, no network: commands in, readings out. The same floor, seed and commands give
bit-identical readings in any process, also when resumed from a snapshot.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from tca_bus import TcaError
from xavier_sim.body import BodyState, Disc, Physics, wrap
from xavier_sim.crowd import Crowd
from xavier_sim.floors import Doors, DoorStanding, UnknownDoorError, build_geometry, space_at
from xavier_sim.messages import FloorPlan, SpaceKind
from xavier_sim.noise import derived_seed
from xavier_sim.profile import STEPS_PER_TICK, XAVIER, RobotProfile
from xavier_sim.robot import Reading, Robot
from xavier_sim.sensors import Rays

BEFORE_DOOR = 0.9
"""A robot in the corridor is before a door when its centre is this near to it, metres."""

DOOR_SWING = 0.05
"""A door does not shut on what is nearer to it than this, metres."""

ROOMY = 0.3
"""Metres that are left free round a robot that is put on the floor to begin with."""

SPOTS = 10_000
"""Spots round the start that are tried for a robot."""

COMPANY = 0.2
"""What is farther from a robot than this, in metres, is not touched within a tick."""

ROBOT = "xavier"
"""The name of a robot that is alone."""

Command = tuple[float, float]
"""Wanted speed in m/s and turn rate in rad/s."""


class NotFreeError(TcaError, ValueError):
    """The robot cannot stand at a point, in metres; ``why`` is a half-sentence about it."""

    exit_code = 2

    def __init__(self, x: float, y: float, why: str) -> None:
        self.x, self.y, self.why = x, y, why
        super().__init__(f"the robot cannot be put at ({x:.5g}, {y:.5g}): {why}")


class RobotsError(TcaError, ValueError):
    """The names of a world's robots cannot be used; ``expected`` says what could."""

    exit_code = 2

    def __init__(self, names: Sequence[str], expected: str) -> None:
        self.names, self.expected = tuple(names), expected
        super().__init__(f"robots are {', '.join(names) or 'none'}; expected {expected}")


@dataclass(frozen=True)
class Truth:
    """Where a robot really is: metres, radians; ``space`` and ``room`` hold it.

    ``people_touched`` counts contacts with people, ``people_hit`` those in which the robot came
    towards them faster than 0.1 m/s; ``hardest_hit`` is the fastest of all, m/s.
    """

    x: float
    y: float
    theta: float
    room: str | None
    space: str | None
    metres: float
    bumps: int
    tick: int
    people_touched: int
    people_hit: int
    hardest_hit: float


class World:
    """One floor, the robots on it, and the people and carts in their way.

    Robots see each other and all the rest, and run into it. The first stands at the floor's start,
    others as near to it as there is room. Methods without a robot's name are about the first.

    Args:
        plan: a valid floor plan.
        seed: of all noise, 0 or more.
        profile: the robots' body and sensors.
        robots: their names.
        people: how many walk the corridors.
        carts: how many stand in them.
        rays: what casts the rays of their sensors; what they sense does not depend on it.

    Raises:
        RobotsError: a name stands twice, or there is none.
        NotFreeError: there is no room for so many robots.
        NoRoomError: there is none for so many people or carts.
    """

    def __init__(
        self,
        plan: FloorPlan,
        seed: int = 0,
        profile: RobotProfile = XAVIER,
        *,
        robots: Sequence[str] = (ROBOT,),
        people: int = 0,
        carts: int = 0,
        rays: Rays = "numpy",
    ) -> None:
        if not robots or len(set(robots)) < len(robots):
            raise RobotsError(robots, "one name or more, each once")
        self.plan, self.seed, self.profile = plan, seed, profile
        self.people, self.carts = people, carts
        self.geometry = build_geometry(plan)
        self._doors = Doors(self.geometry)
        self._physics = Physics(self.geometry)
        self.robots: dict[str, Robot] = {}
        for name in robots:
            self.robots[name] = self._make_robot(name, rays)
        self.robot = self.robots[robots[0]]
        self._crowd = Crowd(plan, seed, people=people, carts=carts, robots=self._robot_discs())
        self._in_company = False
        self.tick = 0
        self._look_round()
        for robot in self.robots.values():
            robot.switch_on()

    def step(self, speed: float, turn_rate: float) -> Reading:
        """Drive the first robot for one control tick of 0.1 s and sense; the others stop.

        Args:
            speed: wanted velocity along the heading, m/s; clipped to what the base can do.
            turn_rate: wanted rad/s, counter-clockwise positive; clipped likewise.
        """
        self.robot.command(speed, turn_rate)
        for robot in self.robots.values():
            if robot is not self.robot:
                robot.command(0.0, 0.0)
        self._advance()
        return self.robot.reading

    def step_all(self, commands: Mapping[str, Command]) -> dict[str, Reading]:
        """Drive all robots for one control tick; one without a command stops."""
        for name, robot in self.robots.items():
            robot.command(*commands.get(name, (0.0, 0.0)))
        self._advance()
        return {name: robot.reading for name, robot in self.robots.items()}

    @property
    def reading(self) -> Reading:
        """What the first robot sensed last."""
        return self.robot.reading

    def truth(self, robot: str | None = None) -> Truth:
        """Where a robot really is."""
        one = self.robots[robot] if robot else self.robot
        state = one.state
        space = space_at(self.plan, state.x, state.y)
        is_room = space is not None and space.kind is SpaceKind.ROOM
        room = space.name if space and is_room else self._doors.near(state.x, state.y, BEFORE_DOOR)
        return Truth(
            x=state.x,
            y=state.y,
            theta=wrap(state.theta),
            room=room,
            space=space.name if space else None,
            metres=one.metres,
            bumps=one.bumps,
            tick=self.tick,
            people_touched=one.people_met.count,
            people_hit=one.people_met.hits,
            hardest_hit=one.people_met.hardest,
        )

    def doors(self) -> dict[str, bool]:
        """Whether a door is open, by the room that it belongs to: any, if that has several."""
        return self._doors.by_room()

    @property
    def open_doors(self) -> dict[str, bool]:
        """Whether each door is open, by its own name."""
        return self._doors.snapshot()

    @property
    def pose(self) -> tuple[float, float, float]:
        """Where the first robot really is: x, y in metres, theta in radians, not wrapped."""
        state = self.robot.state
        return state.x, state.y, state.theta

    @property
    def each_door(self) -> list[DoorStanding]:
        """How every door stands; the same list until one moves."""
        return self._doors.each()

    def set_door(self, name: str, *, is_open: bool) -> DoorStanding:
        """Open or shut a door, and tell how it stands now.

        A door does not shut on a robot: it stays open while one stands in it.

        Raises:
            UnknownDoorError: there is neither a room nor a door of that name.
        """
        door = self._doors.find(name)
        if is_open or not self._is_blocked(door):
            self._doors.is_open[door] = is_open
            self._show_door(door)
        return self._doors.standing(door)

    def place_robot(self, x: float, y: float, theta: float, robot: str | None = None) -> None:
        """Put a robot down somewhere else, standing still; the odometry does not notice."""
        (self.robots[robot] if robot else self.robot).place(x, y, theta)

    def kidnap(
        self, x: float, y: float, theta: float | None = None, robot: str | None = None
    ) -> None:
        """Put a robot down at a point in metres; it looks where it looked, or along ``theta``.

        Raises:
            NotFreeError: it does not fit there.
        """
        one = self.robots[robot] if robot else self.robot
        why = self._why_not_free(x, y, one.profile.base.radius, moving=one)
        if why is not None:
            raise NotFreeError(x, y, why)
        one.place(x, y, one.state.theta if theta is None else theta)

    def place_of(self, room: str) -> tuple[float, float]:
        """The point in metres where a robot serves a room.

        Raises:
            UnknownDoorError: there is no such room.
        """
        if room not in self.plan.places:
            raise UnknownDoorError(room, list(self.plan.places))
        at = self.plan.places[room]
        return at.x, at.y

    def snapshot(self) -> dict[str, Any]:
        """The whole state as JSON can hold it; `restore` goes on from it bit for bit."""
        return {
            "floor": self.plan.name,
            "seed": self.seed,
            "tick": self.tick,
            "doors": self._doors.snapshot(),
            "crowd": self._crowd.snapshot(),
            "robots": {name: robot.snapshot() for name, robot in self.robots.items()},
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot of a world with the same floor, profile and robots.

        In one from before there could be several robots, the only one is not named.

        Raises:
            RobotsError: it is of other robots.
        """
        robots = state.get("robots", dict.fromkeys(list(self.robots)[:1], state))
        if list(robots) != list(self.robots):
            raise RobotsError(list(self.robots), f"{', '.join(robots)}, as in the snapshot")
        self.tick = state["tick"]
        self._doors.restore(state["doors"])
        for door in range(len(self._doors.is_open)):
            self._show_door(door)
        for name, robot in self.robots.items():
            robot.restore(robots[name], self.tick)
        if "crowd" in state:
            self._crowd.restore(state["crowd"])
        self._physics.surround({})
        self._in_company = False
        self._look_round()

    @property
    def discs(self) -> list[Disc]:
        """The people and carts, as all see them and run into them."""
        return self._crowd.discs

    @property
    def _is_lonely(self) -> bool:
        """Whether there is nothing in this world but one robot."""
        return len(self.robots) == 1 and not self._crowd.discs

    def _advance(self) -> None:
        robots = self.robots.values()
        if not self._is_lonely:
            self._move_crowd()
        for _ in range(STEPS_PER_TICK):
            for robot in robots:
                robot.push()
            self._physics.step()
            for robot in robots:
                robot.feel()
        self.tick += 1
        if not self._is_lonely:
            self._look_round()
        for robot in robots:
            robot.sense(self.tick)

    def _move_crowd(self) -> None:
        """Let people and carts move, and put those whom a robot might touch into the physics."""
        bumped = {one for robot in self.robots.values() for one in robot.people_met.touched}
        discs = self._robot_discs()
        self._crowd.step(self.tick, discs, bumped)
        near = {
            number
            for robot in discs
            for number, disc in enumerate(self._crowd.discs)
            if disc.gap(robot.x, robot.y, robot.radius) < COMPANY
        }
        close = {number: self._crowd.discs[number] for number in sorted(near)}
        meet = any(
            one.gap(two.x, two.y, two.radius) < COMPANY for one, two in combinations(discs, 2)
        )
        if close or meet or self._in_company:
            self._physics.surround(close)
        self._in_company = bool(close or meet)

    def _look_round(self) -> None:
        """Put before each robot's sensors what stands about: people, carts and other robots."""
        for name, robot in self.robots.items():
            others = [one.disc for other, one in self.robots.items() if other != name]
            at, sight = robot.state, robot.sight
            rows = [
                (disc.x, disc.y, disc.radius)
                for disc in (*self._crowd.discs, *others)
                if disc.gap(at.x, at.y, 0.0) < sight
            ]
            robot.around = np.array(rows) if rows else None

    def _robot_discs(self) -> list[Disc]:
        return [robot.disc for robot in self.robots.values()]

    def _make_robot(self, name: str, rays: Rays) -> Robot:
        start = self._start()
        # The noise of the first does not depend on whether there are others.
        seed = derived_seed(self.seed, name) if self.robots else self.seed
        body = self._physics.add_robot(self.profile.base, start)
        return Robot(body, self.geometry, self.profile, seed, charger=self.plan.charger, rays=rays)

    def _start(self) -> BodyState:
        """The floor's start, or the nearest free spot on a spiral round it."""
        at, radius = self.plan.start, self.profile.base.radius
        if not self.robots:
            return BodyState(at.x, at.y, self.plan.start_heading)
        for spot in range(1, SPOTS):
            away, angle = 0.2 * math.sqrt(spot), spot * math.pi * (3.0 - math.sqrt(5.0))
            x, y = at.x + away * math.cos(angle), at.y + away * math.sin(angle)
            if self._why_not_free(x, y, radius + ROOMY) is None:
                return BodyState(x, y, self.plan.start_heading)
        raise NotFreeError(at.x, at.y, f"{len(self.robots)} others leave no room round the start")

    def _why_not_free(
        self, x: float, y: float, radius: float, moving: Robot | None = None
    ) -> str | None:
        """Why a disc does not fit at a point, None when it does."""
        if space_at(self.plan, x, y) is None:
            return "that lies in no space of the floor"
        if self._doors.clearance(x, y) <= radius:
            return "a wall or a closed door is in the way"
        for name, other in self.robots.items():
            if other is not moving and other.disc.gap(x, y, radius) <= 0.0:
                return f"{name} stands there"
        if moving and any(disc.gap(x, y, radius) <= 0.0 for disc in self._crowd.discs):
            return "somebody or something stands there"
        return None

    def _show_door(self, door: int) -> None:
        """Let physics and rays know how a door stands."""
        is_open = self._doors.is_open[door]
        self._physics.set_door(door, is_open=is_open)
        self._crowd.see_door(door, is_open=is_open)
        for robot in self.robots.values():
            robot.see_door(door, is_open=is_open)

    def _is_blocked(self, door: int) -> bool:
        return any(
            self._doors.distances(disc.x, disc.y)[door] < disc.radius + DOOR_SWING
            for disc in (*self._robot_discs(), *self._crowd.discs)
        )
