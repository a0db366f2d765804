"""The command that runs the whole office."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from cyclopts.validators import Number

from rogue.cli._flags import PEOPLE, PLANNER, ROBOT, PeopleFlags, PlannerFlags, RobotFlags
from rogue.cli._folders import default_folder, make_folder
from rogue.cli._guard import guarded, office_policy
from rogue.office import OfficeOptions, office_specs
from tca_bus import BusOptions, ConfigError
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, bus_options, note
from tca_bus.launcher import Launcher


async def up(
    *,
    map: str | None = None,  # noqa: A002 - as the flag is named
    seed: Annotated[int, Parameter(validator=Number(gte=0))] = 0,
    speed: str = "1",
    data: Annotated[Path | None, Parameter(env_var="TCA_DATA")] = None,
    secure: Annotated[bool, Parameter(negative="")] = False,
    policy: Annotated[Path | None, Parameter(env_var="TCA_POLICY")] = None,
    planner: PlannerFlags = PLANNER,
    robot: RobotFlags = ROBOT,
    people: PeopleFlags = PEOPLE,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Run the whole office: router, central, robot, speech, navigator and planner.

    Parameters
    ----------
    map
        Floor plan: the name of a built-in one or a file; the fifth floor if not given.
    seed
        Of everything random in the simulated world, 0 or more.
    speed
        Simulated seconds per second, or max for as fast as the machine can.
    data
        Folder in which everything kept lies; the user's state folder if not given.
    secure
        Encrypt, let in only who has keys, and only to what the policy allows. Keys are made in
        the folder "keys" of --data, or of --keys, and the router listens on tls.
    policy
        Policy file that says who may do what; with --secure the office's own if not given.
    planner
        What planner it is.
    robot
        What robot it is, and what it meets in the corridors.
    people
        Who is in the office.
    """
    check_speed(speed)
    told = {**planner.told(), **vars(robot), **vars(people)}
    bus = bus_options(flags).model_copy(update={"clock": "sim"})
    folder = make_folder(data or default_folder(flags.realm))
    if secure:
        policy = policy or office_policy()
        bus = guarded(bus, folder, policy)
    options = OfficeOptions(
        data=folder,
        map=map,
        seed=seed,
        speed=speed,
        policy=policy,
        log_level=flags.level,
        **told,
    )
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
