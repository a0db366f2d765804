"""The processes of a whole office, as `rogue up` and `rogue demo` start them."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from navigate.messages import LocalizerName
from rogue.planning import Rules
from tca_bus import BusOptions
from tca_bus.launcher import ModulePresent, ProcessSpec, Ready, RouterListening
from xavier_sim.messages import ProfileName

People = Literal["auto", "keyboard"]

SIDE_BY_SIDE = dict.fromkeys(("xavier", "speech", "navigate"), ("central",))
"""Those that need only what is named here ready before them, not all that start earlier."""

CORRIDORS = ("people_walking", "carts")

TOLD = {
    "router": ("policy",),
    "central": ("data",),
    "xavier": ("map", "seed", "speed", "epoch", "profile", "battery", *CORRIDORS, "data"),
    "speech": ("seed", "people", "silence", "silent_people", "away", "missing_items", "data"),
    "navigate": ("map", "localizer", "data"),
    "rogue": ("rules", "level", "directory", "finger", "priority", "tray", "later", "data"),
}
"""Which options each process is told, as flags of the same names."""


@dataclass(frozen=True, kw_only=True)
class OfficeOptions:
    """What kind of office.

    ``map`` is a floor plan, by name or as a file, None for the built-in one; ``speed`` is
    simulated seconds per second or ``max`` for lockstep; ``epoch`` is the simulated time at the
    start in ISO 8601. ``profile`` is the robot's, ``battery`` the hours that its battery lasts,
    ``localizer`` what tells the navigator where it is, None for its own choice; ``people_walking``
    are in the corridors, and ``carts``. ``silence`` is the share of
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
    profile: ProfileName = "xavier"
    battery: float | None = None
    localizer: LocalizerName | None = None
    people_walking: int = 0
    carts: int = 0
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

    def module(name: str, package: str, command: str, *, terminal: bool = False) -> ProcessSpec:
        argv = _argv(package, command, options, TOLD[name])
        return _spec(name, argv, ModulePresent(name, bus), terminal=terminal)

    router = _argv("tca_bus", "router", options, TOLD["router"])
    return [
        _spec("router", router, RouterListening(bus)),
        module("central", "tca_bus", "central"),
        module("xavier", "xavier_sim", "run"),
        module("speech", "xavier_sim", "speech", terminal=options.people == "keyboard"),
        module("navigate", "navigate", "run"),
        module("rogue", "rogue", "agent"),
    ]


def _argv(package: str, command: str, options: OfficeOptions, names: Iterable[str]) -> list[str]:
    flags = [word for name in names for word in _flag(name, getattr(options, name))]
    level = ["--log-level", options.log_level]
    return [sys.executable, "-m", package, command, *flags, *level]


def _flag(name: str, value: object) -> list[str]:
    """An option as words of a command line; none of what is not given."""
    if value is None:
        return []
    if isinstance(value, Path):
        value = value.absolute()
    return [f"--{name.replace('_', '-')}", str(value)]


def _spec(name: str, argv: Sequence[str], ready: Ready, *, terminal: bool = False) -> ProcessSpec:
    return ProcessSpec(
        name,
        argv,
        ready=ready,
        after=SIDE_BY_SIDE.get(name),
        stdin="inherit" if terminal else "none",
        output="inherit" if terminal else "log",
    )
