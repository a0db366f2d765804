"""The control rules of the published examples."""

from __future__ import annotations

from rogue.errands._advice import CONSUMERS
from rogue.errands._agenda import robot_room
from rogue.errands._tour import Distance
from rogue.prodigy import Action, Candidate, Choice, Instance, Operator, Rule, SearchView


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


def goto_for_consumer_rule() -> Rule:
    """Select the pickup GOTO iff an ACQUIRE needs the room, the delivery GOTO iff a DELIVER."""

    def fits(view: SearchView, it: Candidate, _among: tuple[Candidate, ...]) -> bool:
        if not isinstance(it, Operator) or it.name not in CONSUMERS or view.goal is None:
            return False
        return any(c.name in CONSUMERS[it.name] for c in view.consumers(view.goal))

    return Rule("goto-for-consumer", Choice.OPERATOR, Action.SELECT, fits)


def _is_goto(candidate: Candidate) -> bool:
    return isinstance(candidate, Instance) and candidate.name in CONSUMERS


def _room(candidate: Candidate) -> str:
    assert isinstance(candidate, Instance)
    return str(candidate.value("room"))
