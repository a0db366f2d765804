"""How each operator of the office domain is carried out and its outcome verified.

The words are those of Figure 6 of Haigh & Veloso (1996); the retries are those of Haigh & Veloso
(1998), section on monitoring: three tries, then the planner is told where the robot is.
"""

from __future__ import annotations

from navigate.messages import NavigateToGoal, NavigationFailure, RoomLocation, SetPosition
from rogue import trace
from rogue.execution._asking import YES, ask, typed
from rogue.execution._effects import Locate, Part, Pause, Perform, Procedure, Tell
from rogue.execution._patience import Patience
from rogue.execution._verification import Verification
from rogue.outcomes import NOTHING, Outcome, StepOutcome
from xavier_sim.messages import Ask

WHEN_FINISHED = "Please indicate on my keyboard when you are finished."

BLOCKED = frozenset(
    {
        NavigationFailure.DOOR_BLOCKED,
        NavigationFailure.CORRIDOR_BLOCKED,
        NavigationFailure.NO_ROUTE,
    }
)
"""Failures of navigation that time may cure."""


def go_to(room: str, patience: Patience, arrival: Verification) -> Procedure:
    """GOTO-PICKUP-LOC and GOTO-DELIVER-LOC: drive to a room and make sure that it is the one."""
    found: str | None = None
    why = "not tried"
    for _ in range(patience.tries):
        drive = yield from _drive(room, patience)
        if drive.failure in BLOCKED:
            yield from _failed("GOTO-LOCATION", room.upper())
            return StepOutcome(kind="failed", reason=f"cannot get to {room}, {drive.reason}")
        found = yield from _arrived_at(room, drive, patience, arrival)
        if found == room:
            yield Tell(trace.completed_line("GOTO-LOCATION", room.upper()))
            yield Tell("")
            return StepOutcome(kind="done", room=room)
        why = drive.reason if drive.failed else "unverified: this may be another place"
    yield from _failed("GOTO-LOCATION", room.upper())
    if found is not None:
        return StepOutcome(kind="elsewhere", room=found, reason=f"the robot is at {found}")
    reason = f"cannot get to {room} in {patience.tries} tries, {why}"
    return StepOutcome(kind="failed", reason=reason)


def _arrived_at(
    room: str, drive: Outcome, patience: Patience, arrival: Verification
) -> Part[str | None]:
    """Where the robot stands after a drive; the navigator is told if it is elsewhere."""
    if not drive.failed:
        yield Tell(trace.verifying_line(room))
        found = yield from arrival.place(room, patience)
    elif drive.failure == NavigationFailure.LOST:
        found = yield from arrival.place(None, patience)
    else:
        return None
    if found is None or (found == room and not drive.failed):
        return found
    position = yield Perform(SetPosition(room=found))
    if position.failed:
        yield Tell(trace.remark(position.reason))
        return None
    yield Tell(trace.remark(f"The robot is at {found.upper()}."))
    yield Tell("")
    return found


def _failed(action: str, *arguments: str) -> Part[None]:
    yield Tell(trace.failed_line(action, *arguments))
    yield Tell("")


def acquire(room: str, user: str, item: str, phrase: str, patience: Patience) -> Procedure:
    """ACQUIRE-ITEM: have somebody put the item on the tray."""
    question = Ask(
        question=f"Are you finished placing {phrase} on my tray? (y/i(mpossible))",
        choices=("y", "i"),
        about="placing",
        room=room,
        user=user,
        item=item,
        timeout=patience.answer_within,
    )
    request = f"Please place {phrase} on my tray."
    return (yield from _hand_over("ACQUIRE-ITEM", request, question, phrase, patience))


def deliver(room: str, user: str, item: str, phrase: str, patience: Patience) -> Procedure:
    """DELIVER-ITEM: have somebody take the item from the tray."""
    question = Ask(
        question=f"Are you finished taking {phrase} from my tray? (y/i(mpossible))",
        choices=("y", "i"),
        about="taking",
        room=room,
        user=user,
        item=item,
        timeout=patience.answer_within,
    )
    request = f"Please take {phrase} from my tray."
    return (yield from _hand_over("DELIVER-ITEM", request, question, phrase, patience))


def _drive(room: str, patience: Patience) -> Part[Outcome]:
    """Navigate to the room; a blocked way is tried again for a while, it may be cleared."""
    found = yield Locate(room)
    if found.failed:
        return found
    location = RoomLocation.model_validate(found.value)
    outcome = NOTHING
    for number in range(patience.blocked_tries):
        if number:
            yield Tell(trace.remark(f"Trying again in {patience.pause:g} s."))
            yield Pause(patience.pause)
        for line in trace.navigate_lines(location.x, location.y):
            yield Tell(line)
        outcome = yield Perform(NavigateToGoal(x=location.x, y=location.y))
        word = "FAILED" if outcome.failed else "ACHIEVED"
        yield Tell(trace.action_line("NAVIGATE-TO-GOAL", word))
        if outcome.failed:
            yield Tell(trace.remark(outcome.reason))
        yield Tell("")
        if outcome.failure not in BLOCKED:
            break
    return outcome


def _hand_over(
    action: str, request: str, question: Ask, phrase: str, patience: Patience
) -> Procedure:
    answer = yield from ask((request, WHEN_FINISHED), question, patience)
    if not answer.failed and typed(answer) == YES:
        yield Tell(trace.completed_line(action, f'"{phrase}"'))
        yield Tell("")
        return StepOutcome(kind="done", room=question.room)
    reason = answer.reason if answer.failed else "impossible: the person there said so"
    yield from _failed(action, f'"{phrase}"')
    return StepOutcome(
        kind="failed", room=question.room, reason=f"{action.lower()} at {question.room}, {reason}"
    )
