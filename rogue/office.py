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
    simulated seconds per second or ``max`` for lockstep; ``epoch`` is the simulated time at the
    start in ISO 8601, ``battery`` the hours that a battery lasts; ``silence`` is the share of
    questions that simulated people do not answer, ``silent_people`` that of people who never do,
    ``away`` that of the time in which somebody is out, ``missing_items`` that of the items that
    are not there, all None for the simulator's own; ``data`` is the folder in which everything
    kept lies; ``policy`` is the file that says who may do what, for a router with keys;
    ``directory`` is a people directory, None for the built-in one, ``finger`` the address of a
    finger server, ``level`` that of the planner's trace, ``priority`` the place of a function
    that ranks errands, ``tray`` how many items the tray holds, ``later`` the minutes after which
    the robot comes back to where it was in vain, all None for the planner's own.
    """

    data: Path
    map: str | None = None
    seed: int = 0
    speed: str = "1"
    people: People = "auto"
    silence: float | None = None
    silent_people: float | None = None
    away: float | None = None
    missing_items: float | None = None
    epoch: str | None = None
    battery: float | None = None
    rules: Rules = Rules.WORKING
    log_level: str = "info"
    policy: Path | None = None
    directory: Path | None = None
    finger: str | None = None
    level: int = 2
    priority: str | None = None
    tray: int | None = None
    later: float | None = None


def office_specs(options: OfficeOptions, bus: BusOptions) -> list[ProcessSpec]:
    """The processes in the order in which they start; the robot's start side by side."""
    map_flags = _given(map=options.map)
    data = ["--data", str(options.data)]
    seed = ["--seed", str(options.seed)]
    guard = _given(policy=options.policy and options.policy.absolute())

    def module(
        name: str, package: str, command: str, flags: Sequence[str], *, terminal: bool = False
    ) -> ProcessSpec:
        argv = _argv(package, command, flags, options)
        return _spec(name, argv, ModulePresent(name, bus), terminal=terminal)

    return [
        _spec("router", _argv("tca_bus", "router", guard, options), RouterListening(bus)),
        module("central", "tca_bus", "central", data),
        module("xavier", "xavier_sim", "run", [*map_flags, *seed, *_robot(options), *data]),
        module(
            *("speech", "xavier_sim", "speech", [*seed, *_people(options), *data]),
            terminal=options.people == "keyboard",
        ),
        module("navigate", "navigate", "run", [*map_flags, *data]),
        module("rogue", "rogue", "agent", [*_planner(options), *data]),
    ]


def _robot(options: OfficeOptions) -> list[str]:
    return _given(speed=options.speed, epoch=options.epoch, battery=options.battery)


def _people(options: OfficeOptions) -> list[str]:
    return _given(
        people=options.people,
        silence=options.silence,
        silent_people=options.silent_people,
        away=options.away,
        missing_items=options.missing_items,
    )


def _planner(options: OfficeOptions) -> list[str]:
    return _given(
        rules=options.rules.value,
        level=options.level,
        directory=options.directory and options.directory.absolute(),
        finger=options.finger,
        priority=options.priority,
        tray=options.tray,
        later=options.later,
    )


def _given(**values: object) -> list[str]:
    """The flags of what is not None."""
    words = []
    for name, value in values.items():
        if value is not None:
            words += [f"--{name.replace('_', '-')}", str(value)]
    return words


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
