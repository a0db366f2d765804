"""The simulated world: a pure function of floor, seed and the commands per tick.

No clock, no network: one command in, one reading out. The same floor, seed and commands give
bit-identical readings in any process, also when resumed from a snapshot.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tca_bus import TcaError, near_matches, near_or_all
from xavier_sim.body import (
    Battery,
    BodyState,
    Bumpers,
    Contact,
    Odometry,
    Physics,
    clip_command,
    next_speed,
    next_turn_rate,
    wrap,
)
from xavier_sim.floors import build_geometry, space_at
from xavier_sim.messages import FloorPlan, SpaceKind
from xavier_sim.profile import STEPS_PER_TICK, TICK, XAVIER, RobotProfile
from xavier_sim.sensors import Camera, Look, Rays, SonarRing, make_caster

BEFORE_DOOR = 0.9
"""A robot in the corridor is before a door when its centre is this near to it, metres."""


STANDING = 1e-4
"""A robot that moves no more than this in a tick stands, metres."""

ON_WALL = 0.05
"""What is so near before a wall, in metres, is on it."""


class UnknownDoorError(TcaError, LookupError):
    """The floor has no door of that name and no room with a door."""

    exit_code = 2

    def __init__(self, name: str, known: list[str]) -> None:
        self.name = name
        self.near = near_matches(name, known)
        hint = near_or_all(name, known)
        super().__init__(f"there is no room or door {name!r} on this floor.{hint}")


class NotFreeError(TcaError, ValueError):
    """The robot cannot stand at a point, in metres; ``why`` is a half-sentence about it."""

    exit_code = 2

    def __init__(self, x: float, y: float, why: str) -> None:
        self.x, self.y, self.why = x, y, why
        super().__init__(f"the robot cannot be put at ({x:.5g}, {y:.5g}): {why}")


@dataclass(frozen=True)
class Reading:
    """What the robot senses at the end of a tick: the fields of `Sensors`, less the time.

    ``sonar`` has shape (24,), metres from the ring, ``inf`` for no echo; ``odom`` shape (3,).
    """

    tick: int
    sonar: NDArray[np.float32]
    sonar_fresh: int
    odom: NDArray[np.float32]
    speed: float
    turn_rate: float
    bump: int


@dataclass(frozen=True)
class Truth:
    """Where the robot really is: metres, radians; ``space`` and ``room`` hold it."""

    x: float
    y: float
    theta: float
    room: str | None
    space: str | None
    metres: float
    bumps: int
    tick: int


class World:
    """One floor and one robot on it.

    Args:
        plan: a valid floor plan.
        seed: of all noise, 0 or more.
        profile: the robot's body and sensors.
        rays: what casts the rays of its sensors; what they sense does not depend on it.
    """

    def __init__(
        self,
        plan: FloorPlan,
        seed: int = 0,
        profile: RobotProfile = XAVIER,
        *,
        rays: Rays = "numpy",
    ) -> None:
        self.plan, self.seed, self.profile = plan, seed, profile
        self.geometry = build_geometry(plan)
        start = BodyState(plan.start.x, plan.start.y, plan.start_heading)
        self._physics = Physics(self.geometry, profile.base, start)
        segments = np.concatenate([self.geometry.walls, self.geometry.doors])
        reach = profile.sonar.farthest + profile.sonar.ring_radius
        self._caster = make_caster(rays, segments, reach)
        self._odometry = Odometry(profile.odometry, seed)
        self._sonar = SonarRing(profile.sonar, seed)
        self._bumpers = Bumpers()
        self.camera = Camera(self.geometry, profile.camera, seed)
        self.battery = Battery(profile.battery) if profile.battery else None
        self._index = _door_index(self.geometry.door_names, self.geometry.door_rooms)
        self._open = [True] * len(self.geometry.door_names)
        for door in range(len(self._open)):
            self._set_door(door, is_open=True)
        self.tick, self.metres = 0, 0.0
        fresh = self._sonar.fire_all(self._caster, start.x, start.y, start.theta)
        self.reading = self._read(fresh, 0)

    def step(self, speed: float, turn_rate: float) -> Reading:
        """Drive for one control tick of 0.1 s and sense.

        Args:
            speed: wanted velocity along the heading, m/s; clipped to what the base can do.
            turn_rate: wanted rad/s, counter-clockwise positive; clipped likewise.
        """
        if self.battery and self.battery.empty:
            speed, turn_rate = 0.0, 0.0
        before = self._physics.state
        touches, prevented = self._drive(*clip_command(self.profile.base, speed, turn_rate))
        now = self._physics.state
        self.tick += 1
        way = math.hypot(now.x - before.x, now.y - before.y)
        self.metres += way
        if self.battery:
            self.battery.use(way, TICK, at_charger=way < STANDING and self._at_charger(now))
        self._reckon(before, now, prevented)
        panels, began = self._bumpers.feel(touches, now.theta)
        if began:
            self._odometry.jolt()
        fresh = self._sonar.fire(self.tick, self._caster, now.x, now.y, now.theta)
        self.reading = self._read(fresh, panels)
        return self.reading

    def truth(self) -> Truth:
        """Where the robot really is."""
        state = self._physics.state
        space = space_at(self.plan, state.x, state.y)
        is_room = space is not None and space.kind is SpaceKind.ROOM
        room = space.name if space and is_room else self._door_near(state.x, state.y)
        where = space.name if space else None
        turn = wrap(state.theta)
        return Truth(
            state.x, state.y, turn, room, where, self.metres, self._bumpers.count, self.tick
        )

    def doors(self) -> dict[str, bool]:
        """Whether each door is open, by the room it belongs to."""
        return dict(zip(self.geometry.door_rooms, self._open, strict=True))

    @property
    def open_doors(self) -> dict[str, bool]:
        """Whether each door is open, by its own name."""
        return dict(zip(self.geometry.door_names, self._open, strict=True))

    @property
    def pose(self) -> tuple[float, float, float]:
        """Where the robot really is: x, y in metres, theta in radians, not wrapped."""
        state = self._physics.state
        return state.x, state.y, state.theta

    def set_door(self, name: str, *, is_open: bool) -> tuple[str, bool]:
        """Open or shut a door, and tell its room and how it stands now.

        A door does not shut on the robot: it stays open while the robot stands in it.

        Raises:
            UnknownDoorError: there is neither a room nor a door of that name.
        """
        if name not in self._index:
            raise UnknownDoorError(name, list(self._index))
        door = self._index[name]
        if is_open or not self._robot_in_door(door):
            self._set_door(door, is_open=is_open)
        return self.geometry.door_rooms[door], self._open[door]

    def look(self) -> Look:
        """Read a door plate with the camera."""
        state = self._physics.state
        return self.camera.look(state.x, state.y, state.theta, self.tick, self._sees)

    def place_robot(self, x: float, y: float, theta: float) -> None:
        """Put the robot down somewhere else, standing still; the odometry does not notice."""
        self._physics.state = BodyState(x, y, theta)

    def kidnap(self, x: float, y: float, theta: float | None = None) -> None:
        """Put the robot down at a point in metres; it looks where it looked, or along ``theta``.

        Raises:
            NotFreeError: it does not fit there.
        """
        if space_at(self.plan, x, y) is None:
            raise NotFreeError(x, y, "that lies in no space of the floor")
        if self._clearance(x, y) <= self.profile.base.radius:
            raise NotFreeError(x, y, "a wall or a closed door is in the way")
        self.place_robot(x, y, self._physics.state.theta if theta is None else theta)

    def place_of(self, room: str) -> tuple[float, float]:
        """The point in metres where the robot serves a room.

        Raises:
            UnknownDoorError: there is no such room.
        """
        if room not in self.plan.places:
            raise UnknownDoorError(room, list(self.plan.places))
        at = self.plan.places[room]
        return at.x, at.y

    def beside(self, ahead: float, left: float) -> tuple[float, float]:
        """The point so many metres ahead of the robot and to its left."""
        state = self._physics.state
        cos, sin = math.cos(state.theta), math.sin(state.theta)
        return state.x + ahead * cos - left * sin, state.y + ahead * sin + left * cos

    def slip(self, metres: float, turn: float) -> None:
        """Make the odometry go wrong by so many metres, and radians."""
        self._odometry.slip(metres, turn)

    @property
    def slipping(self) -> float:
        """Metres that the odometry has still to count wrongly."""
        return self._odometry.slipping

    def snapshot(self) -> dict[str, Any]:
        """The whole state as JSON can hold it; `restore` goes on from it bit for bit."""
        return {
            "floor": self.plan.name,
            "seed": self.seed,
            "tick": self.tick,
            "metres": self.metres,
            "body": asdict(self._physics.state),
            "doors": dict(zip(self.geometry.door_names, self._open, strict=True)),
            "odometry": self._odometry.snapshot(),
            "sonar": self._sonar.snapshot(),
            "bumpers": self._bumpers.snapshot(),
            "camera": self.camera.snapshot(),
            "battery": self.battery.snapshot() if self.battery else None,
            "reading": [self.reading.sonar_fresh, self.reading.bump],
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot of a world with the same floor and profile.

        One that is so old that it knows no camera and no battery leaves them as they are.
        """
        self.tick, self.metres = state["tick"], state["metres"]
        self._physics.state = BodyState(**state["body"])
        for door, name in enumerate(self.geometry.door_names):
            self._set_door(door, is_open=state["doors"].get(name, True))
        self._odometry.restore(state["odometry"])
        self._sonar.restore(state["sonar"])
        self._bumpers.restore(state["bumpers"])
        if "camera" in state:
            self.camera.restore(state["camera"])
        if self.battery and state.get("battery"):
            self.battery.restore(state["battery"])
        self.reading = self._read(*state["reading"])

    def _drive(self, speed: float, turn_rate: float) -> tuple[list[Contact], float]:
        """Step the physics through a tick; contacts, and the metres that a wall prevented."""
        base, touches, prevented = self.profile.base, list[Contact](), 0.0
        for _ in range(STEPS_PER_TICK):
            state = self._physics.state
            wanted = next_speed(base, state.forward_speed(), speed)
            touched = self._physics.step(wanted, next_turn_rate(base, state.turn_rate, turn_rate))
            if touched:
                touches += touched
                prevented += (speed - self._physics.state.forward_speed()) * TICK / STEPS_PER_TICK
        return touches, prevented

    def _reckon(self, before: BodyState, now: BodyState, prevented: float) -> None:
        heading = (before.theta + now.theta) / 2
        ahead = (now.x - before.x) * math.cos(heading) + (now.y - before.y) * math.sin(heading)
        slipped = self.profile.odometry.slip * prevented
        self._odometry.move(ahead + slipped, now.theta - before.theta)

    def _read(self, fresh: int, panels: int) -> Reading:
        state = self._physics.state
        return Reading(
            tick=self.tick,
            sonar=self._sonar.readings.copy(),
            sonar_fresh=fresh,
            odom=self._odometry.pose(),
            speed=state.forward_speed(),
            turn_rate=state.turn_rate,
            bump=panels,
        )

    def _set_door(self, door: int, *, is_open: bool) -> None:
        self._open[door] = is_open
        self._physics.set_door(door, is_open=is_open)
        self._caster.switch(len(self.geometry.walls) + door, on=not is_open)

    def _at_charger(self, state: BodyState) -> bool:
        at, battery = self.plan.charger, self.profile.battery
        if at is None or battery is None:
            return False
        return math.dist((at.x, at.y), (state.x, state.y)) <= battery.charger_reach

    def _sees(self, x: float, y: float) -> bool:
        """Whether nothing stands between the robot and a point of a wall."""
        state = self._physics.state
        angle = math.atan2(y - state.y, x - state.x)
        hits, _ = self._caster.cast(np.array([[state.x, state.y]]), np.array([angle]))
        return bool(hits[0] > math.dist((x, y), (state.x, state.y)) - ON_WALL)

    def _clearance(self, x: float, y: float) -> float:
        """Metres from a point to the nearest wall or closed door."""
        shut = [not is_open for is_open in self._open]
        solid = np.concatenate([np.ones(len(self.geometry.walls), dtype=bool), shut])
        return float(self._caster.distances(x, y)[solid].min(initial=math.inf))

    def _door_distances(self, x: float, y: float) -> NDArray[np.float64]:
        return self._caster.distances(x, y)[len(self.geometry.walls) :]

    def _robot_in_door(self, door: int) -> bool:
        state = self._physics.state
        distance = self._door_distances(state.x, state.y)[door]
        return bool(distance < self.profile.base.radius + 0.05)

    def _door_near(self, x: float, y: float) -> str | None:
        distances = self._door_distances(x, y)
        if distances.size == 0:
            return None
        nearest = int(distances.argmin())
        return self.geometry.door_rooms[nearest] if distances[nearest] <= BEFORE_DOOR else None


def _door_index(names: tuple[str, ...], rooms: tuple[str, ...]) -> dict[str, int]:
    index = {name: i for i, name in reversed(list(enumerate(rooms)))}
    index.update({name: i for i, name in enumerate(names)})
    return index
