"""Navigators by name: found among the entry points of installed packages, or by import string."""

from __future__ import annotations

import inspect
from importlib.metadata import EntryPoint, entry_points
from typing import Any, cast

from tca_bus import TcaError, did_you_mean
from xavier_sim.messages import FloorPlan
from xavier_sim.soak._contract import NavigatorCore, NavigatorFactory

GROUP = "xavier.navigators"
"""The entry points under which packages offer a `NavigatorFactory`."""


class NavigatorError(TcaError, LookupError):
    """A navigator cannot be had. ``name`` is what was asked for, ``why`` a half-sentence."""

    exit_code = 2

    def __init__(self, name: str, why: str) -> None:
        self.name, self.why = name, why
        super().__init__(f"navigator {name!r} {why}")


def navigator_names() -> list[str]:
    """The names under which installed packages offer navigators."""
    return sorted({point.name for point in entry_points(group=GROUP)})


def load_factory(name: str) -> NavigatorFactory:
    """Load what makes a navigator.

    Args:
        name: of an entry point, or ``module:attribute``.

    Raises:
        NavigatorError: there is none of that name, or it cannot be imported or called.
    """
    found = list(entry_points(group=GROUP, name=name))
    if not found and ":" not in name:
        hint = did_you_mean(name, navigator_names()) or " Name one as module:attribute."
        known = ", ".join(navigator_names()) or "none"
        raise NavigatorError(name, f"is not installed; installed: {known}.{hint}")
    if not found and not all(part.strip() for part in name.split(":")):
        raise NavigatorError(name, "is neither installed nor named as module:attribute")
    point = found[0] if found else EntryPoint(name, name, GROUP)
    try:
        factory = point.load()
    except (ImportError, AttributeError) as error:
        raise NavigatorError(name, f"cannot be imported: {error}") from error
    if not callable(factory):
        raise NavigatorError(name, f"is a {type(factory).__name__}, expected a callable")
    return cast("NavigatorFactory", factory)


def make_navigator(
    name: str, plan: FloorPlan, *, seed: int, options: dict[str, str]
) -> NavigatorCore[Any]:
    """Load a factory and make a navigator.

    Raises:
        NavigatorError: as `load_factory`, or it takes no such options, or what it makes lacks
            something of `NavigatorCore`.
    """
    try:
        made = load_factory(name)(plan, seed=seed, **options)
    except TypeError as error:
        raise NavigatorError(name, f"takes no such options: {error}") from error
    if not isinstance(made, NavigatorCore):
        lacking = ", ".join(sorted(set(MEMBERS) - set(dir(made))))
        raise NavigatorError(name, f"makes a {type(made).__name__}, which lacks {lacking}")
    return made


def settings_of(name: str, options: dict[str, str]) -> dict[str, str]:
    """The options that a navigator is made with, those of its own defaults that are text included.

    Raises:
        NavigatorError: as `load_factory`.
    """
    factory = load_factory(name)
    try:
        parameters = inspect.signature(factory).parameters.values()
    except ValueError:
        return options
    return {one.name: one.default for one in parameters if isinstance(one.default, str)} | options


MEMBERS = ("cancel", "freeze", "pose", "report", "set_pose", "start", "step", "thaw")
"""What `NavigatorCore` asks for."""
