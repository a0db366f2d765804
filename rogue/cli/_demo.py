"""The command that plays the papers' scenarios end to end."""

from __future__ import annotations

import asyncio
import sys
import tempfile
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from rogue import trace
from rogue.cli._flags import ROBOT, RobotFlags
from rogue.cli._folders import make_folder
from rogue.cli._trace import followed
from rogue.memory import FILE_NAME
from rogue.messages import TraceLine
from rogue.office import OfficeOptions
from rogue.scenarios import EPOCH, SCENARIOS, Observer, Prompter, Scenario, stage
from tca_bus import ConfigError, Module, TcaError, TimedOutError
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, emit, emit_json, note

Name = Literal["figure6", "figure9", "figure11", "example1998", "failure", "normal", "undone"]

PATIENCE = 300.0
"""Wall seconds that a scenario may take."""


class DemoFailedError(TcaError):
    """A request of the scenario was not completed."""


async def demo(
    name: Name = "figure6",
    /,
    *,
    seed: Annotated[int, Parameter(validator=Number(gte=0))] = 0,
    data: Annotated[Path | None, Parameter(env_var="TCA_DATA")] = None,
    robot: RobotFlags = ROBOT,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Play one of the papers' scenarios in an office of its own, as fast as the machine can.

    The conversation goes to standard output, ending with a line of measurements.

    Parameters
    ----------
    name
        figure6: one request; figure9: a second, more urgent one comes while the robot drives;
        figure11: a plan half done is merged with another; example1998: figure9 as told in 1998;
        failure: navigation ends at the wrong door; normal: a more important request interrupts;
        undone: the same before the item was on the tray.
    seed
        Of everything random in the simulated world, 0 or more.
    data
        Folder for what is kept, and for the logs; a temporary one if not given.
    robot
        What robot it is, and what it meets in the corridors.
    """
    with tempfile.TemporaryDirectory(prefix="rogue-demo-") as temporary:
        folder = make_folder(data or Path(temporary))
        if (folder / FILE_NAME).exists():
            raise ConfigError("--data", str(folder), "a folder in which no office has run yet")
        try:
            await _play(SCENARIOS[name], folder, seed, robot, flags)
        except (TcaError, TimeoutError):
            if not flags.verbose:
                _show_logs(folder / "logs")
            raise


async def _play(
    scenario: Scenario, folder: Path, seed: int, robot: RobotFlags, flags: BusFlags
) -> None:
    options = OfficeOptions(
        data=folder,
        seed=seed,
        speed="max",
        silence=0.0,
        epoch=EPOCH,
        rules=scenario.rules,
        log_level=flags.level,
        **vars(robot),
    )
    console = sys.stderr if flags.verbose else None
    async with stage(options, realm=flags.realm, console=console) as office:
        try:
            async with asyncio.timeout(PATIENCE):
                await _watch(office.module, scenario, flags)
        except TimeoutError:
            raise TimedOutError("the scenario", PATIENCE) from None


async def _watch(module: Module, scenario: Scenario, flags: BusFlags) -> None:
    observer, prompter = Observer(module), Prompter(module, scenario)
    await observer.begin()
    async for line in followed(module):
        _say(line, flags)
        await observer.see(line)
        await prompter.see(line.text)
        if line.text == trace.LISTENING:
            if prompter.is_done:
                break
            await prompter.begin()
    measured = await observer.end()
    failures = await prompter.failures()
    if failures:
        raise DemoFailedError("; ".join(failures))
    if flags.json:
        emit_json({"measured": measured.line()}, line=True)
    else:
        emit(measured.line())


def _say(line: TraceLine, flags: BusFlags) -> None:
    if flags.json:
        emit_json(line, line=True)
    else:
        emit(line.text)


def _show_logs(folder: Path) -> None:
    for file in sorted(folder.glob("*.log")):
        lines = file.read_text(encoding="utf-8", errors="replace").splitlines()
        note(f"--- the last of {file.name}")
        for line in lines[-20:]:
            note(line)
