"""The command that runs the planner process alone."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from rogue.agent import PLACES, AgentOptions, run_agent
from rogue.cli._flags import PLANNER, PlannerFlags
from rogue.cli._folders import default_folder
from rogue.execution import SURE, Patience, Verification, layered
from rogue.planning import Rules
from rogue.requests import finger_server
from tca_bus import configure_logging
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, bus_options

EXECUTION_GROUP = Group("Execution", sort_key=22)

PATIENCE = Patience()


@Parameter(name="*", group=EXECUTION_GROUP)
@dataclass(frozen=True, kw_only=True)
class ExecutionFlags:
    """How plans are carried out."""

    sure: Annotated[float, Parameter(validator=Number(gt=0, lt=1))] = SURE
    """With the working rules: how probable, between 0 and 1, it must be that the robot is where
    it should be before it acts on that."""
    camera: bool = True
    """With the working rules: whether to read door plates."""
    ask_people: bool = True
    """With the working rules: whether to ask a person where the robot is, if nothing else
    makes sure. The papers' rules always ask."""
    later: Annotated[float, Parameter(validator=Number(gt=0))] = PATIENCE.later / 60.0
    """Minutes after which the robot comes back to a room where nobody was, or to which there was
    no way."""
    returns: Annotated[int, Parameter(validator=Number(gte=0))] = PATIENCE.returns
    """How often it comes back, before the errand takes another way or has failed."""

    def arrival(self) -> Verification:
        """How it makes sure where it is."""
        return layered(sure=self.sure, camera=self.camera, people=self.ask_people)

    def patience(self) -> Patience:
        """When it tries again."""
        return replace(PATIENCE, later=60.0 * self.later, returns=self.returns)


EXECUTION = ExecutionFlags()


async def agent(
    *,
    data: Annotated[Path | None, Parameter(env_var="TCA_DATA")] = None,
    planner: PlannerFlags = PLANNER,
    execution: ExecutionFlags = EXECUTION,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Run the ROGUE agent: it accepts requests, plans, and has the robot carry the plans out.

    Parameters
    ----------
    data
        Folder in which requests are kept, as rogue.db.
    planner
        What planner it is.
    execution
        How plans are carried out.
    """
    configure_logging("rogue", level=flags.level, json=flags.json)
    options = AgentOptions(
        folder=data or default_folder(flags.realm),
        rules=Rules(planner.rules),
        level=planner.level,
        directory=planner.directory,
        finger=finger_server(planner.finger) if planner.finger else None,
        metric=planner.metric(),
        places=planner.tray or PLACES,
        arrival=execution.arrival(),
        patience=execution.patience(),
    )
    await run_agent(options, bus_options(flags))
