"""One robot in the world: its body, its dead reckoning, its sensors, and what they read."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from xavier_sim.body import (
    Battery,
    BodyState,
    Bumpers,
    Contact,
    Disc,
    Odometry,
    PeopleMet,
    RobotBody,
    Wheels,
    clip_command,
)
from xavier_sim.floors import Geometry
from xavier_sim.messages import Corner
from xavier_sim.profile import PHYSICS_STEP, TICK, RobotProfile
from xavier_sim.sensors import Camera, Look, Rays, Sensed, Senses

Floats = NDArray[np.float64]

STANDING = 1e-4
"""A robot that moves no more than this in a tick stands, metres."""

ON_WALL = 0.05
"""What is so near before a wall, in metres, is on it."""


class Reading(NamedTuple):
    """What the robot senses at the end of a tick: the fields of `Sensors`, less the time.

    ``sonar`` has shape (24,), metres from the ring, ``inf`` for no echo; ``odom`` shape (3,).
    ``striper`` and ``lidar`` are empty where the robot has none.
    """

    tick: int
    sonar: NDArray[np.float32]
    sonar_fresh: int
    odom: NDArray[np.float32]
    speed: float
    turn_rate: float
    bump: int
    striper: NDArray[np.float32]
    lidar: NDArray[np.float32]


class Robot:
    """A robot's body and senses; the world moves it and lets it sense, tick by tick.

    ``around`` is what the world puts about it, shape (k, 3): x, y and radius in metres.

    Args:
        body: in the physics of the world.
        geometry: of the floor.
        profile: what body and sensors are like.
        seed: of this robot's noise.
        charger: where it can charge its battery, if anywhere.
        rays: what casts the rays of its sensors.
    """

    def __init__(
        self,
        body: RobotBody,
        geometry: Geometry,
        profile: RobotProfile,
        seed: int,
        *,
        charger: Corner | None,
        rays: Rays = "numpy",
    ) -> None:
        self.profile, self._body, self._charger = profile, body, charger
        self.wheels = Wheels(profile.base)
        self._odometry = Odometry(profile.odometry, seed)
        self.senses = Senses(profile, geometry, seed, rays=rays)
        self._bumpers = Bumpers()
        self.people_met = PeopleMet()
        self.camera = Camera(geometry, profile.camera, seed)
        self.battery = Battery(profile.battery) if profile.battery else None
        self.metres = 0.0
        self._wanted, self._pushed = (0.0, 0.0), 0.0
        self._before = body.state
        self._touches: list[Contact] = []
        self._prevented = 0.0
        self.around: Floats | None = None
        self.reading = self._read(0, self.senses.sensed(0), 0)

    @property
    def state(self) -> BodyState:
        """Where it really is, and how it moves."""
        return self._body.state

    @property
    def disc(self) -> Disc:
        """What others see of it, and run into."""
        state = self._body.state
        return Disc(state.x, state.y, self.profile.base.radius)

    @property
    def sight(self) -> float:
        """Metres to which its sensors see at most."""
        return self.senses.reach

    @property
    def bumps(self) -> int:
        """Separate contacts since the world began."""
        return self._bumpers.count

    @property
    def slipping(self) -> float:
        """Metres that the odometry has still to count wrongly."""
        return self._odometry.slipping

    def command(self, speed: float, turn_rate: float) -> None:
        """Take a command for the tick that begins, clipped to what the base can do.

        Args:
            speed: wanted velocity along the heading, m/s.
            turn_rate: wanted rad/s, counter-clockwise positive.
        """
        if self.battery and self.battery.empty:
            speed, turn_rate = 0.0, 0.0
        self._wanted = clip_command(self.profile.base, speed, turn_rate)
        self._before = self._body.state
        self._touches, self._prevented = [], 0.0

    def push(self) -> None:
        """Set the wheels for the physics step that comes."""
        self._pushed, turn_rate = self.wheels.drive(self._body.velocities, self._wanted)
        self._body.push(self._pushed, turn_rate)

    def feel(self) -> None:
        """Take in what the last physics step touched, if anything."""
        contacts = self._body.contacts
        if not contacts:
            return
        state = self._body.state
        self._touches += contacts
        self._prevented += (self._wanted[0] - state.forward_speed()) * PHYSICS_STEP
        for contact in contacts:
            if contact.person is not None:
                closing = self._pushed * math.cos(contact.direction - state.theta)
                self.people_met.touch(contact.person, max(0.0, closing))

    def switch_on(self) -> None:
        """Take the first reading, with all sensors at once."""
        state = self._body.state
        pose = (state.x, state.y, state.theta)
        self.reading = self._read(0, self.senses.switch_on(pose, circles=self.around), 0)

    def sense(self, tick: int) -> Reading:
        """End a tick: reckon, feel and fire the sensors whose turn it is."""
        before, now = self._before, self._body.state
        way = math.hypot(now.x - before.x, now.y - before.y)
        self.metres += way
        if self.battery:
            self.battery.use(way, TICK, at_charger=way < STANDING and self._at_charger(now))
        self._reckon(before, now)
        self.people_met.pass_tick()
        panels, began = self._bumpers.feel(self._touches, now.theta)
        if began:
            self._odometry.jolt()
        sensed = self.senses.sense(tick, (now.x, now.y, now.theta), circles=self.around)
        self.reading = self._read(tick, sensed, panels)
        return self.reading

    def look(self, tick: int) -> Look:
        """Read a door plate with the camera."""
        state = self._body.state
        return self.camera.look(state.x, state.y, state.theta, tick, self._sees)

    def place(self, x: float, y: float, theta: float) -> None:
        """Put it down somewhere else, standing still; the odometry does not notice."""
        self._body.state = BodyState(x, y, theta)

    def beside(self, ahead: float, left: float) -> tuple[float, float]:
        """The point so many metres ahead of it and to its left."""
        state = self._body.state
        cos, sin = math.cos(state.theta), math.sin(state.theta)
        return state.x + ahead * cos - left * sin, state.y + ahead * sin + left * cos

    def slip(self, metres: float, turn: float) -> None:
        """Make the odometry go wrong by so many metres, and radians."""
        self._odometry.slip(metres, turn)

    def see_door(self, door: int, *, is_open: bool) -> None:
        """Let rays through a door, or not."""
        self.senses.see_door(door, is_open=is_open)

    def snapshot(self) -> dict[str, Any]:
        """Everything that `restore` needs, as JSON can hold it."""
        return {
            "metres": self.metres,
            "body": asdict(self._body.state),
            "wheels": self.wheels.snapshot(),
            "odometry": self._odometry.snapshot(),
            **self.senses.snapshot(),
            "bumpers": self._bumpers.snapshot(),
            "people_met": self.people_met.snapshot(),
            "camera": self.camera.snapshot(),
            "battery": self.battery.snapshot() if self.battery else None,
            "reading": [self.reading.sonar_fresh, self.reading.bump],
        }

    def restore(self, state: dict[str, Any], tick: int) -> None:
        """Go back to a snapshot of a robot with the same profile, at a tick.

        One that is so old that it knows no camera, battery or wheels leaves them as they are.
        """
        self.metres = state["metres"]
        self._body.state = BodyState(**state["body"])
        if "wheels" in state:
            self.wheels.restore(state["wheels"])
        self._odometry.restore(state["odometry"])
        self.senses.restore(state)
        self._bumpers.restore(state["bumpers"])
        if "people_met" in state:
            self.people_met.restore(state["people_met"])
        if "camera" in state:
            self.camera.restore(state["camera"])
        if self.battery and state.get("battery"):
            self.battery.restore(state["battery"])
        fresh, panels = state["reading"]
        self.reading = self._read(tick, self.senses.sensed(fresh), panels)

    def _reckon(self, before: BodyState, now: BodyState) -> None:
        heading = (before.theta + now.theta) / 2
        ahead = (now.x - before.x) * math.cos(heading) + (now.y - before.y) * math.sin(heading)
        counted, turn = self.wheels.turned(ahead, now.theta - before.theta)
        self._odometry.move(counted + self.profile.odometry.slip * self._prevented, turn)

    def _read(self, tick: int, sensed: Sensed, panels: int) -> Reading:
        state = self._body.state
        speed, turn_rate = self.wheels.turned(state.forward_speed(), state.turn_rate)
        return Reading(
            tick=tick,
            sonar=sensed.sonar,
            sonar_fresh=sensed.sonar_fresh,
            odom=self._odometry.pose(),
            speed=speed,
            turn_rate=turn_rate,
            bump=panels,
            striper=sensed.striper,
            lidar=sensed.lidar,
        )

    def _at_charger(self, state: BodyState) -> bool:
        at, battery = self._charger, self.profile.battery
        if at is None or battery is None:
            return False
        return math.dist((at.x, at.y), (state.x, state.y)) <= battery.charger_reach

    def _sees(self, x: float, y: float) -> bool:
        """Whether nothing stands between the robot and a point of a wall."""
        state = self._body.state
        angle = math.atan2(y - state.y, x - state.x)
        origin = np.array([[state.x, state.y]])
        hits, _ = self.senses.caster.cast(origin, np.array([angle]), circles=self.around)
        return bool(hits[0] > math.dist((x, y), (state.x, state.y)) - ON_WALL)
