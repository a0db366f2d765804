"""The office in which a soak over the bus takes place: all its processes, in lockstep."""

from __future__ import annotations

import dataclasses
from datetime import UTC, datetime
from pathlib import Path

from rogue.office import OfficeOptions, office_specs
from tca_bus import BusOptions
from tca_bus.launcher import ProcessSpec, free_port
from xavier_sim.floors import load_floor, plan_to_yaml, survey_floor
from xavier_sim.soak import EPOCH, SoakOptions


def bus_of_soak() -> BusOptions:
    """A bus of its own, on simulated time."""
    return BusOptions(connect=f"tcp/127.0.0.1:{free_port()}", realm="soak", clock="sim")


def specs_of_soak(options: SoakOptions, bus: BusOptions, folder: Path) -> list[ProcessSpec]:
    """Router, central, robot, speech, navigator and planner, as the soak's options say.

    The navigator is given the map of the same survey as in one process; it is written to
    ``folder``, in which everything else is kept too.
    """
    surveyed = folder / "surveyed.yaml"
    plan = survey_floor(load_floor(options.floor), sigma=options.survey_sigma, seed=options.seed)
    surveyed.write_text(plan_to_yaml(plan), encoding="utf-8")
    office = OfficeOptions(
        data=folder,
        map=options.floor,
        seed=options.seed,
        speed="max",
        epoch=datetime.fromtimestamp(EPOCH, UTC).isoformat(),
        profile=options.profile,
        people_walking=options.people,
        carts=options.carts,
        log_level="warning",
    )
    own: dict[str, dict[str, object]] = {
        "xavier": {"rays": options.rays},
        "navigate": {"map": surveyed, "seed": options.seed, **options.navigator_options},
    }
    return [_with_flags(spec, own.get(spec.name, {})) for spec in office_specs(office, bus)]


def _with_flags(spec: ProcessSpec, flags: dict[str, object]) -> ProcessSpec:
    """The process with flags of its own, each in place of the office's."""
    argv = list(spec.argv)
    for name, value in flags.items():
        flag = f"--{name}"
        if flag in argv:
            argv[argv.index(flag) + 1] = str(value)
        else:
            argv += [flag, str(value)]
    return dataclasses.replace(spec, argv=argv)
