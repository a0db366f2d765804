"""What world ``xavier run`` shows: its flags, and how it is made or gone on with."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from tca_bus import ConfigError
from xavier_sim.cli._flags import checked_seed
from xavier_sim.floors import DEFAULT_FLOOR, find_floor, load_floor
from xavier_sim.messages import ProfileName
from xavier_sim.profile import PROFILES, XAVIER_CRUISE, BatteryProfile, RobotProfile
from xavier_sim.running import RobotState, SimClock, Team, parse_speed
from xavier_sim.sensors import Rays
from xavier_sim.snapshots import SnapshotError, SnapshotFile
from xavier_sim.world import ROBOT, RobotsError, World

WORLD_GROUP = Group("World", sort_key=10)

Count = Annotated[int, Parameter(validator=Number(gte=0, lte=200))]

LATEST = 16_725_225_600.0
"""Seconds since the epoch, the year 2500: recordings count nanoseconds in 64 bits."""


@Parameter(name="*", group=WORLD_GROUP)
@dataclass(frozen=True, kw_only=True)
class WorldFlags:
    """What makes a world: the same flags and commands give the same readings, bit for bit."""

    map: str = DEFAULT_FLOOR
    """Floor plan: the name of a floor that comes with it, or a YAML file."""
    seed: int = 0
    """Seed of all noise and of all that people do in the corridors, 0 or more."""
    profile: ProfileName = "xavier"
    """The robot: Xavier as a rule, on its bad days, or a robot of today with a lidar."""
    battery: Annotated[float | None, Parameter(env_var="XAVIER_BATTERY")] = None
    """Hours that a full battery lasts standing, or half of them driving; it needs no charging
    when not given."""
    robots: str | None = None
    """Names of several robots in the world, as in "xavier,yoda": each is on the realm of its name.
    One robot on --realm when not given."""
    people_walking: Count = 0
    """How many people walk the corridors and stand about in them."""
    carts: Count = 0
    """How many carts stand in the corridors, now here, now there."""
    rays: Annotated[Rays, Parameter(env_var="XAVIER_RAYS")] = "numpy"
    """What casts the rays of the sensors: numba, the extra "fast", takes a while to start, then is
    quicker, and the same; auto takes it where it is installed."""

    @property
    def names(self) -> tuple[str, ...]:
        """The robots in the world."""
        if self.robots is None:
            return (ROBOT,)
        return tuple(name.strip() for name in self.robots.split(","))


DEFAULT_WORLD = WorldFlags()


def open_world(
    flags: WorldFlags, *, speed: str, data: Path | None, epoch: str | None
) -> tuple[RobotState, SnapshotFile | None]:
    """Make the world of one robot that flags name, or go on with the one in ``data``.

    Raises:
        ConfigError: a flag cannot be used.
        FloorError: the floor plan is wrong.
        NoRoomError: the floor has no room for so many people or carts.
        RobotsError: what lies in the data folder is a world of other robots.
        SnapshotError: it is no world of this floor.
    """
    pace, start = parse_speed(speed), _epoch(epoch)
    state = RobotState(make_world(flags), SimClock(start), speed=pace)
    at_least = start if pace == 1.0 and epoch is None else 0.0
    return state, _resumed(state, data, at_least)


def open_team(
    flags: WorldFlags, *, speed: str, data: Path | None, epoch: str | None
) -> tuple[Team, SnapshotFile | None]:
    """Make the world of several robots that flags name; otherwise as `open_world`."""
    pace, start = parse_speed(speed), _epoch(epoch)
    team = Team(make_world(flags), SimClock(start), speed=pace)
    at_least = start if pace == 1.0 and epoch is None else 0.0
    return team, _resumed(team, data, at_least)


def make_world(flags: WorldFlags) -> World:
    """A fresh world as the flags name it."""
    return World(
        load_floor(str(find_floor(flags.map))),
        checked_seed(flags.seed),
        _with_battery(PROFILES[flags.profile], flags.battery),
        robots=flags.names,
        people=flags.people_walking,
        carts=flags.carts,
        rays=flags.rays,
    )


def _resumed(state: RobotState | Team, data: Path | None, at_least: float) -> SnapshotFile | None:
    """Let a world go on from where it was left, and tell where to keep it."""
    if data is None:
        return None
    store = SnapshotFile(data)
    saved = store.load(floor=state.world.plan.name)
    if saved is None:
        return store
    try:
        state.restore(saved, at_least=at_least)
    except RobotsError:
        raise
    except (LookupError, TypeError, ValueError) as error:
        raise SnapshotError(store.path, "holds no state of such a world") from error
    return store


def _with_battery(profile: RobotProfile, hours: float | None) -> RobotProfile:
    if hours is None:
        return profile
    if not 0.0 < hours < math.inf:
        raise ConfigError("--battery", hours, "hours above 0")
    seconds = 3600.0 * hours
    battery = BatteryProfile(standing_seconds=seconds, metres=seconds * XAVIER_CRUISE)
    return profile.model_copy(update={"battery": battery})


def _epoch(text: str | None) -> float:
    if text is None:
        return time.time()
    try:
        when = datetime.fromisoformat(text).timestamp()
    except (OverflowError, ValueError):
        when = math.nan
    if not 0.0 <= when < LATEST:
        expected = "an ISO 8601 time of the years 1970 to 2499, such as 1997-06-02T09:00"
        raise ConfigError("--epoch", text, expected)
    return when
