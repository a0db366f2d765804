"""navground: a C++ core with Python bindings; kinematics at 10 Hz."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from simulators.base import (
    FURNISHED,
    LIDAR_NOISE,
    LIDAR_RANGE,
    PERIOD,
    RADIUS,
    SONAR_RANGE,
    SONAR_RAYS,
    SPEED,
    START,
    STRIPER_BEAMS,
    STRIPER_RANGE,
    STRIPER_VIEW,
    TURN,
    Simulator,
)


class Navground(Simulator):
    """The world alone, with a lidar. Sensing is called by hand: a C++ call for each robot."""

    title, group, package = "navground", "lidar", "navground"

    def __init__(self, robots: int) -> None:
        super().__init__(robots)
        from navground import core, sim  # noqa: PLC0415 -- not always there

        self._core, self._sim, self._world = core, sim, sim.World()
        for x0, y0, x1, y1 in self.setting.walls:
            self._world.add_wall(sim.Wall(core.LineSegment((x0, y0), (x1, y1))))
        self._eyes: list[tuple[Any, Any, Any]] = []
        for number in range(robots):
            agent = self._agent()
            agent.pose = core.Pose2(START[number], 0.0)
            self._world.add_agent(agent)
            for lidar in self._lidars():
                state = core.SensingState()
                lidar.prepare_state(state)
                self._eyes.append((lidar, agent, state))
        self._command = core.Twist2((SPEED, 0.0), TURN, core.Frame.relative)

    def tick(self) -> None:
        self._move()
        for lidar, agent, state in self._eyes:
            lidar.update(agent, self._world, state)

    def ranges(self) -> np.ndarray:
        lidar, _, state = self._eyes[0]
        return np.array(lidar.read_ranges(state))

    def _move(self) -> None:
        for agent in self._world.agents:
            agent.last_cmd = self._command
        self._world.actuate(PERIOD)

    def _lidars(self) -> list[Any]:
        return [self._lidar(LIDAR_RANGE, 2 * math.pi, self.setting.beams)]

    def _agent(self) -> Any:
        kinematics = self._core.kinematics.TwoWheelsDifferentialDriveKinematics(0.7, 0.5)
        return self._sim.Agent(radius=RADIUS, kinematics=kinematics, control_period=PERIOD)

    def _lidar(self, reach: float, view: float, beams: int) -> Any:
        return self._sim.state_estimations.LidarStateEstimation(
            range=reach,
            start_angle=-view / 2,
            field_of_view=view,
            resolution=beams,
            error_std_dev=LIDAR_NOISE,
        )


class NavgroundFurnished(Navground):
    """The same among furniture."""

    group, setting = "furnished", FURNISHED


class NavgroundLoop(Navground):
    """As many rays as our cones and striper have, and the HL controller, which knows the walls."""

    title, group = "navground, HL behaviour", "loop"

    def _move(self) -> None:
        self._world.update(PERIOD)

    def _lidars(self) -> list[Any]:
        return [
            self._lidar(SONAR_RANGE, 2 * math.pi, SONAR_RAYS),
            self._lidar(STRIPER_RANGE, STRIPER_VIEW, STRIPER_BEAMS),
        ]

    def _agent(self) -> Any:
        kinematics = self._core.kinematics.TwoWheelsDifferentialDriveKinematics(0.7, 0.5)
        return self._sim.Agent(
            radius=RADIUS,
            kinematics=kinematics,
            behavior=self._core.behaviors.HLBehavior(),
            task=self._sim.tasks.WaypointsTask(START, loop=True, tolerance=0.3, random=True),
            state_estimations=[self._sim.state_estimations.BoundedStateEstimation(SONAR_RANGE)],
            control_period=PERIOD,
        )
