"""ROGUE's office: its domain, its rules, and the switches of the papers' examples."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import resources
from typing import NamedTuple

from rogue.errands._tour import Distance
from rogue.prodigy import (
    Action,
    Candidate,
    Choice,
    Domain,
    Instance,
    Literal,
    Operator,
    PollPoint,
    Problem,
    Rule,
    RuleSet,
    SearchOptions,
    SearchView,
    parse_domain,
    parse_problem,
)

ErrandRooms = Callable[[str, str], tuple[str, str] | None]
"""Rooms (pickup, deliver) of the errand of a user and item; None where it is not known."""

PICKUP, DELIVER = "goto-pickup-loc", "goto-deliver-loc"
CONSUMER = {PICKUP: "acquire-item", DELIVER: "deliver-item"}
"""The operator for whose sake each GOTO is chosen."""


class Switches(NamedTuple):
    """What distinguishes one published example from another."""

    options: SearchOptions
    rules: RuleSet


@dataclass(frozen=True, slots=True)
class Errand:
    """A delivery: ``item`` for ``user`` from room ``pickup`` to room ``deliver``.

    Types of the domain: ``person``, ``item``, ``room``. A person with several errands at a time
    needs the rule set ``working`` with ``errands``, since the facts tie rooms to the person only.
    """

    user: str
    item: str
    pickup: str
    deliver: str

    def facts(self) -> tuple[Literal, Literal, Literal]:
        """Return needs-item, pickup-loc and deliver-loc, as in Figure 7."""
        return (
            Literal("needs-item", (self.user, self.item)),
            Literal("pickup-loc", (self.user, self.pickup)),
            Literal("deliver-loc", (self.user, self.deliver)),
        )

    def goal(self) -> Literal:
        """Return ``(has-item user item)``."""
        return Literal("has-item", (self.user, self.item))


def load_office_domain() -> Domain:
    """Return ROGUE's domain, ``domains/office.pdl``."""
    return parse_domain(_text("office.pdl"), file="office.pdl")


def load_office_problem(name: str, domain: Domain) -> Problem:
    """Return one of the problems beside the domain, such as ``figure6``."""
    return parse_problem(_text(f"{name}.pdl"), domain, file=f"{name}.pdl")


def _text(name: str) -> str:
    return resources.files("rogue.errands").joinpath("domains", name).read_text("utf-8")


def nearest_room_rule(distance: Distance) -> Rule:
    """Reject a ready GOTO whose room is farther from the robot than that of another.

    This is the execution constraint control rule of the 1998 example, step 9.
    """

    def is_farther(view: SearchView, it: Candidate, among: tuple[Candidate, ...]) -> bool:
        here = robot_room(view)
        if here is None or not _is_goto(it):
            return False
        nearest = min(distance(here, _room(other)) for other in among if _is_goto(other))
        return distance(here, _room(it)) > nearest

    return Rule("nearest-room", Choice.APPLIED_OP, Action.REJECT, is_farther)


def no_premature_goto_rule() -> Rule:
    """Reject a ready GOTO whose every consumer lacks more, if some other GOTO is not so.

    Going to a delivery room without the item would be undone at once.
    """

    def is_premature(view: SearchView, it: Candidate, among: tuple[Candidate, ...]) -> bool:
        if not _is_goto(it) or not _is_too_early(view, it):
            return False
        return any(_is_goto(other) and not _is_too_early(view, other) for other in among)

    return Rule("no-premature-goto", Choice.APPLIED_OP, Action.REJECT, is_premature)


def goto_for_consumer_rule() -> Rule:
    """Select the pickup GOTO iff an ACQUIRE needs the room, the delivery GOTO iff a DELIVER."""

    def fits(view: SearchView, it: Candidate, _among: tuple[Candidate, ...]) -> bool:
        if not isinstance(it, Operator) or it.name not in CONSUMER or view.goal is None:
            return False
        return any(c.name == CONSUMER[it.name] for c in view.consumers(view.goal))

    return Rule("goto-for-consumer", Choice.OPERATOR, Action.SELECT, fits)


def item_of_consumer_rule() -> Rule:
    """Reject a GOTO for another user or item than those of an operator that needs the room."""

    def is_foreign(view: SearchView, it: Candidate, _among: tuple[Candidate, ...]) -> bool:
        if not isinstance(it, Instance) or it.name not in CONSUMER or view.goal is None:
            return False
        consumers = [c for c in view.consumers(view.goal) if c.name == CONSUMER[it.name]]
        return bool(consumers) and not any(
            (c.value("user"), c.value("item")) == (it.value("user"), it.value("item"))
            for c in consumers
        )

    return Rule("item-of-consumer", Choice.BINDINGS, Action.REJECT, is_foreign)


def errand_rooms_rule(errands: ErrandRooms) -> Rule:
    """Reject ACQUIRE and DELIVER in a room that is not that of the errand."""

    def is_elsewhere(_view: SearchView, it: Candidate, _among: tuple[Candidate, ...]) -> bool:
        if not isinstance(it, Instance) or it.name not in CONSUMER.values():
            return False
        rooms = errands(str(it.value("user")), str(it.value("item")))
        at = 0 if it.name == CONSUMER[PICKUP] else 1
        return rooms is not None and rooms[at] != it.value("room")

    return Rule("errand-rooms", Choice.BINDINGS, Action.REJECT, is_elsewhere)


def robot_room(view: SearchView) -> str | None:
    """Return the room at which the robot is, None if it is at none."""
    rooms = sorted(str(args[0]) for args in view.state.tuples("robot-in-room"))
    return rooms[0] if rooms else None


def _is_goto(candidate: Candidate) -> bool:
    return isinstance(candidate, Instance) and candidate.name in CONSUMER


def _room(candidate: Candidate) -> str:
    assert isinstance(candidate, Instance)
    return str(candidate.value("room"))


def _is_too_early(view: SearchView, candidate: Candidate) -> bool:
    assert isinstance(candidate, Instance)
    assert candidate.goal is not None
    consumers = view.consumers(candidate.goal)
    return all(view.lacking(c) != (candidate.goal,) for c in consumers)


_OFFICE = SearchOptions(
    execute=True, depth_bound=None, max_nodes=None, time_limit=None, proof_states=0
)


def figure6() -> Switches:
    """Return the switches of Figure 6: SABA, no rules, executing, polled at the end of a cycle."""
    return Switches(_OFFICE, RuleSet())


def figure9(distance: Distance) -> Switches:
    """Return the switches of Figure 9: those of Figure 6 and the nearest-room rule."""
    return Switches(_OFFICE, RuleSet((nearest_room_rule(distance),)))


def example1998(distance: Distance) -> Switches:
    """Return those of the 1998 example: operators by consumer, nearest room, earlier poll."""
    rules = (goto_for_consumer_rule(), nearest_room_rule(distance))
    return Switches(_early(), RuleSet(rules))


def working(distance: Distance, *, errands: ErrandRooms | None = None) -> Switches:
    """Return the working rules, which keep planning linear in the number of errands.

    They are: the GOTO is chosen by its consumer; its item is that of the consumer; no premature
    GOTO; of the rest the nearest. Rules added behind them are asked before them.

    Args:
        distance: Metres between two rooms.
        errands: Rooms (pickup, deliver) of an errand by user and item, for people with several
            errands at a time.
    """
    rules = (
        nearest_room_rule(distance),
        no_premature_goto_rule(),
        goto_for_consumer_rule(),
        item_of_consumer_rule(),
    )
    own_rooms = (errand_rooms_rule(errands),) if errands is not None else ()
    return Switches(_early(), RuleSet(rules + own_rooms))


def _early() -> SearchOptions:
    return replace(_OFFICE, poll=PollPoint.BEFORE_EXPANSION)
