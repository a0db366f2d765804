"""What follows from a step's outcome: which errands go on, wait, take another way, or are given up.

Pure. The planner is told only what became of the world and of its goals, and decides the rest.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from rogue.execution._operators import ACQUIRE, TAKING, room_of, thing
from rogue.execution._patience import Patience
from rogue.memory import Facts, Hold, PastStep, Step
from rogue.messages import DeliveryRequest
from rogue.outcomes import StepOutcome, Trouble

PASSING = frozenset(
    {
        Trouble.NOBODY,
        Trouble.BLOCKED,
        Trouble.SHUT_IN,
        Trouble.HINDERED,
        Trouble.UNSURE,
    }
)
"""Troubles that time may cure."""


@dataclass(frozen=True, slots=True)
class Case:
    """All that is known when a step has ended.

    ``served`` are the open requests that it served, ``others`` those whose next room is the same
    one; ``past`` are the steps ended before for each of ``served``, by its id; ``rooms`` where
    else the user of each may be found, by its id. ``facts`` are those after the step.
    """

    step: Step
    outcome: StepOutcome
    served: Sequence[DeliveryRequest]
    others: Sequence[DeliveryRequest]
    past: Mapping[str, Sequence[PastStep]]
    rooms: Mapping[str, Sequence[str]]
    facts: Facts
    now: float


@dataclass(slots=True)
class Verdict:
    """What becomes of the requests of a step.

    ``done`` are delivered; ``hopeless`` have a reason each; ``moved`` are to go on in another
    room; ``holds`` are put off; ``closed`` were given up while their items were to be put on the
    tray, and never were.
    """

    done: list[DeliveryRequest] = field(default_factory=list)
    hopeless: list[tuple[DeliveryRequest, str]] = field(default_factory=list)
    moved: list[DeliveryRequest] = field(default_factory=list)
    holds: list[Hold] = field(default_factory=list)
    closed: list[DeliveryRequest] = field(default_factory=list)


def judge(case: Case, patience: Patience) -> Verdict:
    """Say what becomes of the requests that a step served."""
    verdict = Verdict()
    if case.outcome.kind == "done":
        verdict.done = list(case.served) if case.step.operator in TAKING else []
        return verdict
    for request in case.served:
        _judge_one(case, request, patience, verdict)
    if case.outcome.trouble in PASSING - {Trouble.SHUT_IN} and verdict.holds:
        verdict.holds += [_hold(case, request, patience) for request in case.others]
    return verdict


def _judge_one(case: Case, request: DeliveryRequest, patience: Patience, verdict: Verdict) -> None:
    outcome = case.outcome
    if outcome.trouble is Trouble.UNWANTED or _turned_round(case, request):
        return
    if request.closing is not None and case.step.operator == ACQUIRE:
        verdict.closed.append(request)
        return
    times = 1 + _times_before(case, request)
    reason = outcome.reason or "it could not be done"
    if request.closing is not None and thing(request) in outcome.gone:
        verdict.hopeless.append((request, reason))
    elif outcome.kind == "elsewhere" or outcome.trouble is Trouble.MISTAKEN:
        if times >= patience.wrong_arrivals:
            verdict.hopeless.append((request, f"{reason}, {times} times"))
    elif outcome.trouble in PASSING and _may_wait(case, request, times, patience):
        verdict.holds.append(_hold(case, request, patience))
    elif outcome.trouble is not Trouble.UNABLE and (other := _other_room(case, request)):
        verdict.moved.append(_with_room(case, request, other))
    else:
        counted = f", {times} times" if times > 1 else ""
        verdict.hopeless.append((request, f"{reason}{counted}"))


def _turned_round(case: Case, request: DeliveryRequest) -> bool:
    """Whether the item is on its way back already, so that what failed is of no account."""
    carried = thing(request) in case.facts.tray and thing(request) not in case.outcome.gone
    return request.closing is not None and carried and room_of(case.step) != request.destination


def _times_before(case: Case, request: DeliveryRequest) -> int:
    """How often it came to the same before, at this room."""
    return sum(
        past.outcome.kind == case.outcome.kind
        and past.outcome.trouble == case.outcome.trouble
        and room_of(past) == room_of(case.step)
        for past in case.past.get(request.id, ())
    )


def _may_wait(case: Case, request: DeliveryRequest, times: int, patience: Patience) -> bool:
    in_time = request.closing is not None or case.now + patience.later < request.deadline
    # Whoever is shut in can do nothing else meanwhile.
    return in_time and (times <= patience.returns or case.outcome.trouble is Trouble.SHUT_IN)


def _hold(case: Case, request: DeliveryRequest, patience: Patience) -> Hold:
    until = case.now + patience.later
    reason = case.outcome.reason or "it could not be done"
    trouble = case.outcome.trouble or Trouble.BLOCKED
    room = case.outcome.room if trouble is Trouble.SHUT_IN else None
    return Hold(request.id, room or room_of(case.step), until, reason, trouble)


def _other_room(case: Case, request: DeliveryRequest) -> str | None:
    """Another room of the user, none in which it was tried already."""
    if request.closing is not None:
        return None
    past = case.past.get(request.id, ())
    tried = {room_of(one) for one in past} | {request.pickup, request.deliver}
    left = [room for room in case.rooms.get(request.id, ()) if room not in tried]
    return left[0] if left else None


def _with_room(case: Case, request: DeliveryRequest, room: str) -> DeliveryRequest:
    carried = thing(request) in case.facts.tray
    return request.model_copy(update={"deliver" if carried else "pickup": room})
