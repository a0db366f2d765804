"""The processes of a whole office, as `rogue up` and `rogue demo` start them."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from rogue.planning import Rules
from tca_bus import BusOptions
from tca_bus.launcher import ModulePresent, ProcessSpec, Ready, RouterListening

People = Literal["auto", "keyboard"]

SIDE_BY_SIDE = dict.fromkeys(("xavier", "speech", "navigate"), ("central",))
"""Those that need only what is named here ready before them, not all that start earlier."""


@dataclass(frozen=True, kw_only=True)
class OfficeOptions:
    """What kind of office.

    ``map`` is a floor plan, by name or as a file, None for the built-in one; ``speed`` is
    simulated seconds per second or ``max`` for lockstep; ``silence`` is the share of questions
    that simulated people do not answer, ``epoch`` the simulated time at the start in ISO 8601,
    both None for the simulator's own; ``data`` is the folder in which everything kept lies;
    ``policy`` is the file that says who may do what, for a router with keys; ``directory`` is a
    people directory, None for the built-in one, ``finger`` the address of a finger server,
    ``level`` that of the planner's trace.
    """

    data: Path
    map: str | None = None
    seed: int = 0
    speed: str = "1"
    people: People = "auto"
    silence: float | None = None
    epoch: str | None = None
    rules: Rules = Rules.WORKING
    log_level: str = "info"
    policy: Path | None = None
    directory: Path | None = None
    finger: str | None = None
    level: int = 2


def office_specs(options: OfficeOptions, bus: BusOptions) -> list[ProcessSpec]:
    """The processes in the order in which they start; the robot's start side by side."""
    map_flags = ["--map", options.map] if options.map else []
    data = ["--data", str(options.data)]
    world = [*map_flags, "--seed", str(options.seed), "--speed", options.speed, *data]
    if options.epoch is not None:
        world += ["--epoch", options.epoch]
    speech = ["--people", options.people, "--seed", str(options.seed), *data]
    if options.silence is not None:
        speech += ["--silence", str(options.silence)]
    guard = ["--policy", str(options.policy.absolute())] if options.policy is not None else []
    agent = ["--rules", options.rules.value, "--level", str(options.level), *data]
    if options.directory is not None:
        agent += ["--directory", str(options.directory.absolute())]
    if options.finger is not None:
        agent += ["--finger", options.finger]

    def module(
        name: str, package: str, command: str, flags: Sequence[str], *, terminal: bool = False
    ) -> ProcessSpec:
        argv = _argv(package, command, flags, options)
        return _spec(name, argv, ModulePresent(name, bus), terminal=terminal)

    return [
        _spec("router", _argv("tca_bus", "router", guard, options), RouterListening(bus)),
        module("central", "tca_bus", "central", data),
        module("xavier", "xavier_sim", "run", world),
        module("speech", "xavier_sim", "speech", speech, terminal=options.people == "keyboard"),
        module("navigate", "navigate", "run", [*map_flags, *data]),
        module("rogue", "rogue", "agent", agent),
    ]


def _argv(package: str, command: str, flags: Sequence[str], options: OfficeOptions) -> list[str]:
    level = ["--log-level", options.log_level]
    return [sys.executable, "-m", package, command, *flags, *level]


def _spec(name: str, argv: Sequence[str], ready: Ready, *, terminal: bool = False) -> ProcessSpec:
    return ProcessSpec(
        name,
        argv,
        ready=ready,
        after=SIDE_BY_SIDE.get(name),
        stdin="inherit" if terminal else "none",
        output="inherit" if terminal else "log",
    )
