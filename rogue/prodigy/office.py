"""ROGUE's office: its domain, its rules, and the switches of the papers' examples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from rogue.prodigy._domain import Domain
from rogue.prodigy._options import SearchOptions
from rogue.prodigy._rules import Rule, RuleSet
from rogue.prodigy._terms import Literal

Distance = Callable[[str, str], float]
"""Metres of the route from one room to another."""


class Switches(NamedTuple):
    """What distinguishes one published example from another."""

    options: SearchOptions
    rules: RuleSet


@dataclass(frozen=True, slots=True)
class Errand:
    """A delivery: ``item`` for ``user`` from room ``pickup`` to room ``deliver``.

    Types of the domain: ``person``, ``item``, ``room``. A person with several errands needs the
    rule set ``working`` with ``errands``, since the facts tie rooms to the person only.
    """

    user: str
    item: str
    pickup: str
    deliver: str

    def facts(self) -> tuple[Literal, Literal, Literal]:
        """Return needs-item, pickup-loc and deliver-loc, as in Figure 7."""
        raise NotImplementedError

    def goal(self) -> Literal:
        """Return ``(has-item user item)``."""
        raise NotImplementedError


def load_office_domain() -> Domain:
    """Return ROGUE's domain, ``domains/office.pdl``."""
    raise NotImplementedError


def nearest_room_rule(distance: Distance) -> Rule:
    """Reject a ready GOTO whose room is farther from the robot than that of another."""
    raise NotImplementedError


def figure6() -> Switches:
    """Return the switches of Figure 6: SABA, no rules, executing, polled at the end of a cycle."""
    raise NotImplementedError


def figure9(distance: Distance) -> Switches:
    """Return the switches of Figure 9: those of Figure 6 and the nearest-room rule."""
    raise NotImplementedError


def example1998(distance: Distance) -> Switches:
    """Return those of the 1998 example: operators by consumer, nearest room, earlier poll."""
    raise NotImplementedError


def working(
    distance: Distance, *, errands: Callable[[str, str], tuple[str, str] | None] | None = None
) -> Switches:
    """Return the working rules: four of them, linear in the number of errands.

    Args:
        distance: Metres between two rooms.
        errands: Rooms (pickup, deliver) of an errand by user and item, for people with several;
            None where it is not known.
    """
    raise NotImplementedError
