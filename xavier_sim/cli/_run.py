"""``xavier run``: the simulated robot."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from tca_bus import configure_logging
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, bus_options
from xavier_sim.cli._flags import Data
from xavier_sim.cli._worlds import DEFAULT_WORLD, WorldFlags, open_team, open_world
from xavier_sim.running import RobotModule, run_team


async def run(
    *,
    speed: str = "1",
    data: Data = None,
    epoch: str | None = None,
    record: Path | None = None,
    world: WorldFlags = DEFAULT_WORLD,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Run the simulated robot until it is stopped.

    Args:
        speed: Simulated seconds per second, or "max" for lockstep with the driver.
        data: Folder to keep the world in, so that a restarted one goes on.
        epoch: Simulated time at the start, ISO 8601; now when not given.
        record: File to record into all that the robot senses and does, what the navigator
            believes, and the tasks; Foxglove shows it. A file of that name is replaced. With
            --robots there is one for each, with the robot's name after the file's.
        world: What world it is.
        flags: Where the bus is.
    """
    configure_logging("xavier", level=flags.level, json=flags.json)
    if world.robots is not None:
        options = {name: bus_options(replace(flags, realm=name)) for name in world.names}
        team, store = open_team(world, speed=speed, data=data, epoch=epoch)
        if record is None:
            await run_team(team, store, options)
            return
        from xavier_sim.cli._recording import run_team_recorded  # noqa: PLC0415 - as below

        await run_team_recorded(team, store, options, record)
        return
    state, store = open_world(world, speed=speed, data=data, epoch=epoch)
    if record is None:
        await RobotModule(state, store, bus_options(flags)).run()
        return
    from xavier_sim.cli._recording import run_recorded  # noqa: PLC0415 - few runs need it

    await run_recorded(state, store, bus_options(flags), record)
