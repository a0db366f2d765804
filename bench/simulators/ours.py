"""Xavier: physics at 50 Hz, sensors at 10 Hz, with noise; in the loop with the navigator."""

from __future__ import annotations

import numpy as np

from navigate.driving import Drive, Wheels
from navigate.factory import make_navigator
from navigate.navigator import Navigator
from simulators.base import FURNISHED, PLAN, SPEED, START, TURN, Simulator
from xavier_sim.floors import survey_floor
from xavier_sim.messages import FloorPlan, Sensors
from xavier_sim.profile import HARD, LIDAR, MODERN, TICK, RobotProfile
from xavier_sim.robot import Reading
from xavier_sim.world import World


def world_of(robots: int, profile: RobotProfile, plan: FloorPlan = PLAN) -> World:
    """A world with each robot in a room of its own."""
    names = [f"x{number}" for number in range(robots)]
    world = World(plan, 0, profile, robots=names, rays="auto")
    for name, (x, y) in zip(names, START, strict=False):
        world.place_robot(x, y, 0.0, name)
    return world


class Ours(Simulator):
    """The world alone, with a lidar."""

    title, group = "xavier_sim", "lidar"

    def __init__(self, robots: int) -> None:
        super().__init__(robots)
        lidar = LIDAR.model_copy(update={"beams": self.setting.beams})
        modern = MODERN.model_copy(update={"lidar": lidar})
        self._world = world_of(robots, modern, self.setting.plan)
        self._commands = dict.fromkeys(self._world.robots, (SPEED, TURN))

    def tick(self) -> None:
        self._world.step_all(self._commands)

    def ranges(self) -> np.ndarray:
        return self._world.reading.lidar


class OursFurnished(Ours):
    """The same among furniture."""

    group, setting = "furnished", FURNISHED


class OursLoop(Simulator):
    """World and navigator: 24 cones, striper, noise, avoidance, doors, routes; dead reckoning."""

    title, group, localizer = "xavier_sim and navigate, dead reckoning", "loop", "odometry"

    def __init__(self, robots: int) -> None:
        super().__init__(robots)
        self._world = world_of(robots, HARD)
        plan = survey_floor(PLAN, sigma=0.03, seed=0)
        self._drivers = {
            name: _Driver(make_navigator(plan, seed=number, localizer=self.localizer), number)
            for number, name in enumerate(self._world.robots)
        }

    def tick(self) -> None:
        readings = {name: robot.reading for name, robot in self._world.robots.items()}
        wheels = {name: one.step(readings[name]) for name, one in self._drivers.items()}
        self._world.step_all({name: (one.speed, one.turn) for name, one in wheels.items()})

    def ranges(self) -> np.ndarray:
        return self._world.reading.sonar


class OursFiltered(OursLoop):
    """The same, with the particle filter in place of dead reckoning."""

    title, localizer = "xavier_sim and navigate, particle filter", "particles"


class _Driver:
    """A navigator that is sent from room to room without end."""

    def __init__(self, navigator: Navigator, number: int) -> None:
        self._navigator, self._goal = navigator, number
        self._drive: Drive | None = None
        x, y = START[number]
        navigator.set_pose((x, y, 0.0))

    def step(self, reading: Reading) -> Wheels:
        sensors = _sensors(reading)
        if self._drive is None or self._drive.done:
            self._goal = (self._goal + 7) % len(START)
            self._drive = self._navigator.start(START[self._goal], sensors)
        return self._navigator.step(sensors)


def _sensors(reading: Reading) -> Sensors:
    return Sensors.model_construct(
        tick=reading.tick,
        time=reading.tick * TICK,
        period=TICK,
        lockstep=True,
        sonar=reading.sonar,
        sonar_fresh=reading.sonar_fresh,
        striper=reading.striper,
        lidar=reading.lidar,
        odom=reading.odom,
        speed=reading.speed,
        turn_rate=reading.turn_rate,
        bump=reading.bump,
    )
