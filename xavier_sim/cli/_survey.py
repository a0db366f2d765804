"""``xavier survey``: the plan of a floor as a survey gives it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from tca_bus import ConfigError
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, emit_json
from xavier_sim.cli._flags import checked_seed
from xavier_sim.floors import load_floor, plan_to_yaml, survey_floor
from xavier_sim.snapshots import write_atomically


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
