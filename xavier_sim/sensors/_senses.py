"""All range sensors of one robot together, and the one caster behind them."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tca_bus import TcaError
from xavier_sim.floors import Geometry
from xavier_sim.messages import SONAR_COUNT
from xavier_sim.profile import RobotProfile
from xavier_sim.sensors._caster import Floats
from xavier_sim.sensors._choice import Rays, make_caster
from xavier_sim.sensors._cones import Cones
from xavier_sim.sensors._laser import Laser
from xavier_sim.sensors._readings import Pose, Ranges
from xavier_sim.sensors._sonar import SonarRing

ALL_FRESH = (1 << SONAR_COUNT) - 1

NO_BEAMS: Ranges = np.empty(0, dtype=np.float32)


class Sensed(NamedTuple):
    """What the range sensors last read; shapes and units are those of `Sensors`."""

    sonar: Ranges
    sonar_fresh: int
    striper: Ranges
    lidar: Ranges


class NoSensorError(TcaError, LookupError):
    """The robot has no sensor of a ``kind``."""

    exit_code = 2

    def __init__(self, kind: str) -> None:
        self.kind = kind
        super().__init__(f"this robot has no {kind}; 'xavier run --profile' gives it another set")


class Senses:
    """The sonars, striper and lidar that a profile gives a robot.

    Each has a stream of noise of its own. Doors begin open.

    Args:
        profile: of the robot.
        geometry: of the floor.
        seed: of this robot's noise.
        rays: what casts the rays.

    Raises:
        ConfigError: numba is asked for and not installed.
    """

    def __init__(
        self, profile: RobotProfile, geometry: Geometry, seed: int, *, rays: Rays = "numpy"
    ) -> None:
        segments = np.concatenate([geometry.walls, geometry.doors])
        self.reach = _reach(profile)
        self.caster = make_caster(rays, segments, self.reach)
        self._first_door = len(geometry.walls)
        for door in range(len(geometry.doors)):
            self.see_door(door, is_open=True)
        self._sonar = SonarRing(profile.sonar, seed) if profile.sonar else None
        self._striper = Laser(profile.striper, seed, "striper") if profile.striper else None
        self._lidar = Laser(profile.lidar, seed, "lidar") if profile.lidar else None
        self._lasers = [one for one in (self._striper, self._lidar) if one is not None]
        self._cones = Cones(profile.lidar) if profile.lidar else None

    def see_door(self, door: int, *, is_open: bool) -> None:
        """Let rays through a door of the geometry, or not."""
        self.caster.switch(self._first_door + door, on=not is_open)

    def switch_on(self, pose: Pose, *, circles: Floats | None = None) -> Sensed:
        """Fire everything at once."""
        return self._fire(None, pose, circles)

    def sense(self, tick: int, pose: Pose, *, circles: Floats | None = None) -> Sensed:
        """Fire what has its turn at a tick.

        Args:
            tick: of the world.
            pose: of the robot.
            circles: shape (m, 3), x, y and radius in metres of whoever stands about.
        """
        return self._fire(tick, pose, circles)

    def sensed(self, fresh: int) -> Sensed:
        """What was read last, the sonars whose bits are in ``fresh`` just now."""
        lidar = self._lidar.ranges if self._lidar else NO_BEAMS
        striper = self._striper.ranges if self._striper else NO_BEAMS
        if self._sonar is None and self._cones is not None:
            return Sensed(self._cones.read(lidar), ALL_FRESH, striper, lidar)
        readings = self._sonar.readings.copy() if self._sonar else NO_BEAMS
        return Sensed(readings, fresh, striper, lidar)

    def stick_sonar(self, number: int, reading: float | None = None) -> None:
        """Let a sonar always read the same, metres; ``inf`` is a dead one, None what it read last.

        Raises:
            NoSensorError: the robot has no sonars.
        """
        ring = self._ring()
        ring.stuck[number] = float(ring.readings[number]) if reading is None else reading

    def mend_sonar(self, number: int) -> None:
        """Let a sonar hear again.

        Raises:
            NoSensorError: the robot has no sonars.
        """
        self._ring().stuck.pop(number, None)

    def knock_lasers(self, metres: float, turn: float) -> None:
        """Let striper and lidar measure so many metres too far and look so many radians left.

        Raises:
            NoSensorError: the robot has neither.
        """
        if not self._lasers:
            raise NoSensorError("laser")
        for laser in self._lasers:
            laser.metres_off, laser.turned = metres, turn

    @property
    def stuck_sonars(self) -> dict[int, float]:
        """What the faulty sonars read, metres; ``inf`` for a dead one."""
        return dict(self._sonar.stuck) if self._sonar else {}

    @property
    def laser_offset(self) -> tuple[float, float]:
        """Metres that the lasers measure too far, and radians that they look to the left."""
        return next(((one.metres_off, one.turned) for one in self._lasers), (0.0, 0.0))

    def snapshot(self) -> dict[str, Any]:
        """Everything that `restore` needs, as plain values."""
        return {name: sensor.snapshot() for name, sensor in self._by_name().items()}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot; a sensor that it does not know stays as it is."""
        for name, sensor in self._by_name().items():
            if name in state:
                sensor.restore(state[name])

    def _fire(self, tick: int | None, pose: Pose, circles: Floats | None) -> Sensed:
        """Cast the rays of all sensors at once, and give each what its own have met."""
        bundles, fresh = [laser.aim(pose) for laser in self._lasers], 0
        volley = self._sonar.aim(tick, pose) if self._sonar else None
        if volley:
            bundles.append(volley.rays)
        if not bundles:
            return self.sensed(fresh)
        origins = np.concatenate([one.origins for one in bundles])
        angles = np.concatenate([one.angles for one in bundles])
        distance, cosine = self.caster.cast(origins, angles, circles=circles)
        begin = 0
        for laser, bundle in zip(self._lasers, bundles, strict=False):
            end = begin + len(bundle.angles)
            laser.see(distance[begin:end], cosine[begin:end])
            begin = end
        if self._sonar and volley:
            fresh = self._sonar.hear(volley, distance[begin:], cosine[begin:])
        return self.sensed(fresh)

    def _ring(self) -> SonarRing:
        if self._sonar is None:
            raise NoSensorError("sonar")
        return self._sonar

    def _by_name(self) -> dict[str, SonarRing | Laser]:
        sensors = {"sonar": self._sonar, "striper": self._striper, "lidar": self._lidar}
        return {name: sensor for name, sensor in sensors.items() if sensor is not None}


def _reach(profile: RobotProfile) -> float:
    """The longest ray that a robot needs, metres."""
    reaches = [laser.farthest for laser in (profile.striper, profile.lidar) if laser]
    if profile.sonar:
        reaches.append(profile.sonar.farthest + profile.sonar.ring_radius)
    return max(reaches)
