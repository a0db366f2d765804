"""Flags that several commands of ``rogue`` have."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from navigate.messages import LocalizerName
from rogue.errands import MOST_PLACES, Metric, MetricError, RankSum, load_metric
from rogue.office import People
from rogue.planning import RuleName, Rules
from rogue.requests import finger_server
from tca_bus import ConfigError
from xavier_sim.messages import ProfileName

WORLD_GROUP = Group("World", sort_key=10)
PLANNER_GROUP = Group("Planner", sort_key=20)
ROBOT_GROUP = Group("Robot", sort_key=25)
PEOPLE_GROUP = Group("People", sort_key=30)

Count = Annotated[int, Parameter(validator=Number(gte=0, lte=200))]
Share = Annotated[float | None, Parameter(validator=Number(gte=0, lte=1))]


@Parameter(name="*", group=WORLD_GROUP)
@dataclass(frozen=True, kw_only=True)
class WorldFlags:
    """What world it is."""

    map: str | None = None
    """Floor plan: the name of a built-in one or a file; the fifth floor if not given."""
    seed: Annotated[int, Parameter(validator=Number(gte=0))] = 0
    """Of everything random in the simulated world, 0 or more."""
    speed: str = "1"
    """Simulated seconds per second, or max for as fast as the machine can."""

    def told(self) -> dict[str, Any]:
        """What an office is told of it, by the names of `OfficeOptions`.

        Raises:
            ConfigError: ``speed`` is neither ``max`` nor a positive number.
        """
        check_speed(self.speed)
        return vars(self)


@Parameter(name="*", group=PLANNER_GROUP)
@dataclass(frozen=True, kw_only=True)
class PlannerFlags:
    """What planner it is."""

    rules: RuleName = "working"
    """Control rules: none, 1996, 1998 as in the papers' examples, or the working ones."""
    level: Annotated[int, Parameter(validator=Number(gte=2, lte=3))] = 2
    """What the planner tells in the conversation: 2 its nodes, 3 also the rules that decided."""
    directory: Path | None = None
    """YAML file with people, items and services instead of the built-in one."""
    finger: str | None = None
    """HOST or HOST:PORT of a finger server, asked for people and rooms that no directory has."""
    priority: Annotated[str | None, Parameter(env_var="ROGUE_PRIORITY")] = None
    """MODULE:NAME or FILE.py:NAME of a function that gives the priority of an errand, instead of
    PersonRank + TaskRank + DeadlineRank."""
    tray: Annotated[
        int | None, Parameter(env_var="ROGUE_TRAY", validator=Number(gte=1, lte=MOST_PLACES))
    ] = None
    """With the working rules: how many items the tray holds; six if not given."""

    def metric(self) -> Metric:
        """What ranks errands.

        Raises:
            ConfigError: ``priority`` names nothing of use.
        """
        if self.priority is None:
            return RankSum()
        try:
            return load_metric(self.priority)
        except MetricError as error:
            expected = (
                f"MODULE:NAME or FILE.py:NAME of a function of a claim and a time; {error.problem}"
            )
            raise ConfigError("--priority", self.priority, expected) from error

    def told(self) -> dict[str, Any]:
        """What the planner of an office is told, by the names of `OfficeOptions`.

        Raises:
            ConfigError: ``priority`` names nothing of use, or ``finger`` is no address.
        """
        self.metric()
        finger = str(finger_server(self.finger)) if self.finger else None
        return {**vars(self), "rules": Rules(self.rules), "finger": finger}


@Parameter(name="*", group=ROBOT_GROUP)
@dataclass(frozen=True, kw_only=True)
class RobotFlags:
    """What robot it is, and what it meets in the corridors."""

    profile: ProfileName = "xavier"
    """The robot: Xavier as a rule, on its bad days, or a robot of today with a lidar."""
    localizer: LocalizerName | None = None
    """What tells the navigator where it is: a particle filter, a POMDP, or odometry alone; its
    own choice if not given."""
    battery: Annotated[
        float | None, Parameter(env_var="XAVIER_BATTERY", validator=Number(gt=0))
    ] = None
    """Hours that a full battery lasts standing; it needs no charging if not given."""
    people_walking: Count = 0
    """How many people walk the corridors and stand about in them."""
    carts: Count = 0
    """How many carts stand in the corridors, now here, now there."""


@Parameter(name="*", group=PEOPLE_GROUP)
@dataclass(frozen=True, kw_only=True)
class PeopleFlags:
    """Who is in the office, and how they take to a robot."""

    people: People = "auto"
    """auto: simulated people answer the robot; keyboard: you do, in this terminal."""
    silence: Share = None
    """Share of the questions that simulated people do not answer, 0 to 1."""
    silent_people: Annotated[Share, Parameter(env_var="XAVIER_SILENT_PEOPLE")] = None
    """Share of the people who never answer a robot."""
    away: Annotated[Share, Parameter(env_var="XAVIER_AWAY")] = None
    """Share of the time that somebody is out of their room."""
    missing_items: Annotated[Share, Parameter(env_var="XAVIER_MISSING_ITEMS")] = None
    """Share of the items that are not where they are to be picked up."""


WORLD = WorldFlags()
PLANNER = PlannerFlags()
ROBOT = RobotFlags()
PEOPLE = PeopleFlags()


def check_speed(speed: str) -> None:
    """Refuse a speed that the simulator could not take.

    Raises:
        ConfigError: it is neither ``max`` nor a positive number.
    """
    try:
        good = speed == "max" or 0 < float(speed) < float("inf")
    except ValueError:
        good = False
    if not good:
        raise ConfigError("--speed", speed, "a positive number, or max")
