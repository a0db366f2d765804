"""Decisions, goals and steps of the office in sentences for its users."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from rogue.explain._decision import Decision, DecisionKind, Rival
from rogue.explain._rules import because
from rogue.explain._words import plain
from rogue.outcomes import BELIEF, CAMERA, PERSON
from rogue.times import show_time

if TYPE_CHECKING:
    from rogue.outcomes import Arrival

_STEPS = {
    ("goto-pickup-loc", 2): "driving to {1} to fetch something for {0}",
    ("goto-deliver-loc", 2): "driving to {1} to deliver to {0}",
    ("acquire-item", 3): "having {2} for {1} put on the tray in {0}",
    ("deliver-item", 3): "handing {2} over to {1} in {0}",
    ("return-item", 3): "bringing {2} of {1} back to {0}",
}
_GOALS = {
    ("has-item", 2): "that {0} gets {1}",
    ("item-returned", 2): "that {1} of {0} is back where it came from",
    ("robot-has-item", 2): "having {1} for {0} on the tray",
    ("robot-in-room", 1): "being in {0}",
}

_LAYERS = {
    BELIEF: "the navigator's belief",
    CAMERA: "the door plate",
    PERSON: "somebody who was asked",
}

MOST_NAMED = 4
"""Alternatives, or requests, that a sentence names."""


def in_words(text: str) -> str:
    """Return what PRODIGY writes as ``<goto-pickup-loc mitchell r-5303>`` as a user says it.

    What is no goal or step of the office is returned as it is.
    """
    name, *args = text.strip("()<> ").lower().split() or [""]
    table = _GOALS if text.startswith("(") else _STEPS
    pattern = table.get((name, len(args)))
    return pattern.format(*args) if pattern else text


def sentence(decision: Decision, *, again: bool = False) -> str:
    """Return a decision as one sentence; ``again`` if the request was planned for before."""
    match decision.kind:
        case DecisionKind.PLANNED:
            return _planned(decision, "up again" if again else "up")
        case DecisionKind.STEP:
            return _with_reason(f"Next came {in_words(decision.chosen)}", decision)
        case DecisionKind.WAITS:
            return f"It had to wait for {_named(decision.rivals)}: {_instead(decision)}."
        case DecisionKind.OVERTAKEN:
            who = _named(decision.rivals)
            return f"It was overtaken by {who}, which came later: {_instead(decision)}."
        case DecisionKind.MERGED:
            return f"It shares {_shared(decision.chosen)} with {_named(decision.rivals)}."
        case DecisionKind.POSTPONED:
            return put_off("It was put off", decision.until, decision.reason)
        case DecisionKind.RESUMED:
            return f"It can go on: {decision.reason}."
        case DecisionKind.MOVED:
            return f"It goes on elsewhere: {decision.reason}."
        case DecisionKind.DEAD_END:
            return f"Planning found no way by {in_words(decision.chosen)}: {decision.reason}."
    return _with_reason(f"For it the planner chose {in_words(decision.chosen)}", decision)


def verified(arrivals: Sequence[Arrival]) -> str:
    """Return what was found at each arrival of a drive, and who made sure, as a subordinate clause.

    What comes before it is to end without a stop; empty where nothing was asked.
    """
    found = [_found(one) for one in arrivals]
    return f"; {', then '.join(found)}" if found else ""


def _found(arrival: Arrival) -> str:
    if arrival.room is None:
        return "nothing made sure where it was"
    by = _LAYERS.get(arrival.by or "", arrival.by)
    return f"{by} made sure of {arrival.room}"


def _shared(goal: str) -> str:
    name, *args = goal.strip("()").split()
    return f"the drive to {args[0]}" if name == "robot-in-room" and args else in_words(goal)


def put_off(words: str, until: float | None, reason: str) -> str:
    """Return that something waits, until when if that is known, and why."""
    when = "" if until is None else f" until {show_time(until)}"
    return f"{words}{when}: {plain(reason)}."


def _planned(decision: Decision, up: str) -> str:
    before = f", before {_named(decision.rivals)}" if decision.rivals else ""
    why = because(decision.rule) if decision.rivals else ""
    return f"The planner took it {up}{before}{f', {why}' if why else ''}."


def _with_reason(words: str, decision: Decision) -> str:
    others = [in_words(text) for text in decision.over]
    rather = f", rather than {_listed(others)}" if others else ""
    why = because(decision.rule) if others else ""
    return f"{words}{rather}{f', {why}' if why else ''}."


def _instead(decision: Decision) -> str:
    why = because(decision.rule)
    return f"{in_words(decision.chosen)} came first{f', {why}' if why else ''}"


def _named(rivals: Sequence[Rival]) -> str:
    return _listed([f"request {one.id} (rank {one.rank})" for one in rivals]) or "other requests"


def _listed(words: Iterable[str]) -> str:
    named = list(dict.fromkeys(words))
    more = len(named) - MOST_NAMED
    if more > 0:
        named[MOST_NAMED:] = [f"{more} more"]
    if len(named) <= 1:
        return "".join(named)
    return f"{', '.join(named[:-1])} and {named[-1]}"
