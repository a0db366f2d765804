"""Flags that several commands of ``rogue`` have."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from rogue.errands import MOST_PLACES, Metric, MetricError, RankSum, load_metric
from rogue.office import People
from rogue.planning import RuleName
from tca_bus import ConfigError

PLANNER_GROUP = Group("Planner", sort_key=20)
PEOPLE_GROUP = Group("People", sort_key=30)

Share = Annotated[float | None, Parameter(validator=Number(gte=0, lte=1))]


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


PLANNER = PlannerFlags()
PEOPLE = PeopleFlags()
