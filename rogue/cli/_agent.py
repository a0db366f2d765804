"""The command that runs the planner process alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from rogue.agent import PLACES, AgentOptions, run_agent
from rogue.cli._folders import default_folder
from rogue.errands import MOST_PLACES, Metric, MetricError, RankSum, load_metric
from rogue.execution import SURE, Patience, layered
from rogue.planning import RuleName, Rules
from rogue.requests import finger_server
from tca_bus import ConfigError, configure_logging
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, bus_options

PATIENCE = Patience()


async def agent(
    *,
    data: Annotated[Path | None, Parameter(env_var="TCA_DATA")] = None,
    rules: RuleName = "working",
    level: Annotated[int, Parameter(validator=Number(gte=2, lte=3))] = 2,
    directory: Path | None = None,
    finger: str | None = None,
    sure: Annotated[float, Parameter(validator=Number(gt=0, lt=1))] = SURE,
    camera: bool = True,
    ask_people: bool = True,
    later: Annotated[float, Parameter(validator=Number(gt=0))] = PATIENCE.later / 60.0,
    returns: Annotated[int, Parameter(validator=Number(gte=0))] = PATIENCE.returns,
    priority: str | None = None,
    tray: Annotated[int, Parameter(validator=Number(gte=1, lte=MOST_PLACES))] = PLACES,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Run the ROGUE agent: it accepts requests, plans, and has the robot carry the plans out.

    Parameters
    ----------
    data
        Folder in which requests are kept, as rogue.db.
    rules
        Control rules: none, 1996, 1998 as in the papers' examples, or the working ones.
    level
        What the planner tells in the conversation: 2 its nodes, 3 also the rules that decided.
    directory
        YAML file with people, items and services instead of the built-in one.
    finger
        HOST or HOST:PORT of a finger server, asked for people and rooms that no directory has.
    sure
        With the working rules: how probable, between 0 and 1, it must be that the robot is where
        it should be before it acts on that.
    camera
        With the working rules: whether to read door plates.
    ask_people
        With the working rules: whether to ask a person where the robot is, if nothing else
        makes sure. The papers' rules always ask.
    later
        Minutes after which the robot comes back to a room where nobody was, or to which there was
        no way.

    Returns:
        How often it comes back, before the errand takes another way or has failed.
    priority
        MODULE:NAME or FILE.py:NAME of a function that gives the priority of an errand, instead of
        PersonRank + TaskRank + DeadlineRank.
    tray
        With the working rules: how many items the tray holds.
    """
    configure_logging("rogue", level=flags.level, json=flags.json)
    folder = data or default_folder(flags.realm)
    options = AgentOptions(
        folder=folder,
        rules=Rules(rules),
        level=level,
        directory=directory,
        finger=finger_server(finger) if finger else None,
        metric=_metric(priority) if priority else RankSum(),
        places=tray,
        arrival=layered(sure=sure, camera=camera, people=ask_people),
        patience=replace(PATIENCE, later=60.0 * later, returns=returns),
    )
    await run_agent(options, bus_options(flags))


def _metric(name: str) -> Metric:
    try:
        return load_metric(name)
    except MetricError as error:
        expected = (
            f"MODULE:NAME or FILE.py:NAME of a function of a claim and a time; {error.problem}"
        )
        raise ConfigError("--priority", name, expected) from error
