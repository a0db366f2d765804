"""The command that runs the planner process alone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rogue.agent import AgentOptions, run_agent
from rogue.cli._folders import default_folder
from rogue.planning import RuleName, Rules
from tca_bus import configure_logging
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, bus_options


async def agent(
    *,
    data: Annotated[Path | None, Parameter(env_var="TCA_DATA")] = None,
    rules: RuleName = "working",
    people_directory: Path | None = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Run the ROGUE agent: it accepts requests, plans, and has the robot carry the plans out.

    Parameters
    ----------
    data
        Folder in which requests are kept, as rogue.db.
    rules
        Control rules: none, 1996, 1998 as in the papers' examples, or the working ones.
    people_directory
        YAML file with people, items and services instead of the built-in one.
    """
    configure_logging("rogue", level=flags.level, json=flags.json)
    folder = data or default_folder(flags.realm)
    options = AgentOptions(folder=folder, rules=Rules(rules), directory=people_directory)
    await run_agent(options, bus_options(flags))
