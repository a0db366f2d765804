"""The command that runs the whole office."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from rogue.cli._flags import (
    PEOPLE,
    PLANNER,
    ROBOT,
    WORLD,
    PeopleFlags,
    PlannerFlags,
    RobotFlags,
    WorldFlags,
)
from rogue.cli._folders import default_folder, make_folder
from rogue.cli._guard import SECURITY, SecurityFlags
from rogue.office import OfficeOptions, office_specs
from tca_bus import BusOptions
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, bus_options, note
from tca_bus.launcher import Launcher


async def up(
    *,
    data: Annotated[Path | None, Parameter(env_var="TCA_DATA")] = None,
    world: WorldFlags = WORLD,
    security: SecurityFlags = SECURITY,
    planner: PlannerFlags = PLANNER,
    robot: RobotFlags = ROBOT,
    people: PeopleFlags = PEOPLE,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Run the whole office: router, central, robot, speech, navigator and planner.

    Parameters
    ----------
    data
        Folder in which everything kept lies; the user's state folder if not given.
    """
    told = {**world.told(), **planner.told(), **vars(robot), **vars(people)}
    bus = bus_options(flags).model_copy(update={"clock": "sim"})
    folder = make_folder(data or default_folder(flags.realm))
    bus, policy = security.applied(bus, folder)
    options = OfficeOptions(data=folder, policy=policy, log_level=flags.level, **told)
    await _open(options, bus)


async def _open(options: OfficeOptions, bus: BusOptions) -> None:
    async with Launcher(office_specs(options, bus), bus, console=sys.stderr) as launcher:
        note(f"The office is open on {bus.connect}; everything is kept in {options.data}.")
        note(f"In another terminal: rogue request delivermail --user mitchell --wait{_where(bus)}")
        await launcher.serve_forever()


def _where(bus: BusOptions) -> str:
    """The flags that lead to an office that is not where it usually is."""
    usual = BusOptions()
    connect = "" if bus.connect == usual.connect else f" --connect {bus.connect}"
    realm = "" if bus.realm == usual.realm else f" --realm {bus.realm}"
    keys = "" if bus.keys is None else f" --keys {bus.keys}"
    return connect + realm + keys
