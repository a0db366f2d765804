"""The command line ``xavier``."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from tca_bus import ConfigError, configure_logging
from tca_bus.cli import (
    DEFAULT_FLAGS,
    BusFlags,
    bus_options,
    emit_json,
    make_app,
    run_app,
)
from xavier_sim.cli._soak import soak
from xavier_sim.cli._world import COMMANDS
from xavier_sim.cli._worlds import DEFAULT_WORLD, WorldFlags, checked_seed, open_world
from xavier_sim.floors import load_floor, plan_to_yaml, survey_floor
from xavier_sim.office import Habits, Keyboard, RecordFile, SimulatedPeople, SpeechModule, Typist
from xavier_sim.recording import Beginning, Recorder, listening
from xavier_sim.running import RobotModule, RobotState
from xavier_sim.snapshots import write_atomically

app = make_app("xavier", help="The simulated robot, the office round it, and its speech board.")

Share = Annotated[float, Parameter(validator=Number(gte=0.0, lte=1.0))]
Data = Annotated[Path | None, Parameter(env_var="TCA_DATA")]


@app.command
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
            believes, and the tasks; Foxglove shows it. A file of that name is replaced.
        world: What world it is.
        flags: Where the bus is.
    """
    configure_logging("xavier", level=flags.level, json=flags.json)
    state, store = open_world(world, speed=speed, data=data, epoch=epoch)
    if record is None:
        await RobotModule(state, store, bus_options(flags)).run()
        return
    options = bus_options(flags)
    async with Recorder(record, beginning_of(state)) as recorder, listening(recorder, options):
        await RobotModule(state, store, options, recorder).run()


@app.command
async def speech(
    *,
    people: Literal["auto", "keyboard"] = "auto",
    seed: int = 0,
    silence: Share = 0.05,
    silent_people: Share = 0.0,
    away: Share = 0.0,
    missing_items: Share = 0.0,
    data: Data = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Run the speech board and the keyboard until they are stopped.

    Args:
        people: Who answers: simulated people, or whoever sits at this terminal.
        seed: Seed of what the simulated people do, 0 or more.
        silence: Share of questions that the simulated people leave unanswered, 0 to 1.
        silent_people: Share of the people who never answer a robot.
        away: Share of the time that somebody is out of their room.
        missing_items: Share of the items that are not where they are to be picked up.
        data: Folder to keep what was said in, so that a restarted one does nothing twice.
        flags: Where the bus is.
    """
    configure_logging("speech", level=flags.level, json=flags.json)
    module = SpeechModule(bus_options(flags), RecordFile(data))
    if people == "auto":
        habits = Habits(
            silence=silence, silent_people=silent_people, away=away, missing_items=missing_items
        )
        await module.run(SimulatedPeople(module, seed=checked_seed(seed), habits=habits))
        return
    # A file of its own: the interpreter cannot end while a thread holds the lock of sys.stdin.
    async with Keyboard(os.fdopen(os.dup(0)), sys.stdout) as keyboard:
        await module.run(Typist(module.module, keyboard))


@app.command
def survey(
    floor: str,
    /,
    *,
    seed: int = 0,
    sigma: float = 0.03,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Write the plan of a floor with the small errors of a survey, for a navigator.

    Args:
        floor: Floor plan: the name of a floor that comes with it, or a YAML file.
        seed: Seed of the errors, 0 or more.
        sigma: Standard deviation of the errors of walls and doors, metres.
        output: File to write.
        flags: Shared flags; no bus is needed.
    """
    if not 0.0 <= sigma <= 0.2:
        raise ConfigError("--sigma", sigma, "metres from 0 to 0.2")
    surveyed = survey_floor(load_floor(floor), sigma=sigma, seed=checked_seed(seed))
    title = f"# {surveyed.name} as surveyed: walls and doors are off by about {sigma:g} m"
    note = "metres, x east, y north"
    write_atomically(output, f"{title}; {note}.\n{plan_to_yaml(surveyed)}")
    if flags.json:
        emit_json({"floor": surveyed.name, "sigma": sigma, "seed": seed, "output": str(output)})


def beginning_of(state: RobotState) -> Beginning:
    """How things stand, for a recording that begins now."""
    return Beginning(
        floor=state.world.plan,
        seed=state.world.seed,
        speed=state.speed,
        time=state.now,
        doors=tuple(state.door_states()),
        battery=state.battery_state(),
    )


app.command(soak)
for command in COMMANDS:
    app.command(command)


def main() -> None:
    """Run the command line."""
    run_app(app)
