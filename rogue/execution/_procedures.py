"""How each operator of the office domain is carried out: preconditions, action, postconditions.

The words are those of Figure 6 of Haigh & Veloso (1996); the retries are those of Haigh & Veloso
(1998), section on monitoring: three tries, then the planner is told where the robot is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

from navigate.messages import (
    NavigateToGoal,
    NavigationFailure,
    NoticeLandmark,
    Position,
    RoomLocation,
    SetPosition,
)
from rogue import trace
from rogue.execution._asking import NO_ANSWER, YES, ask, say, typed
from rogue.execution._effects import (
    AwaitCharge,
    Believe,
    CheckTray,
    Locate,
    Part,
    Perform,
    Procedure,
    Tell,
)
from rogue.execution._patience import Patience
from rogue.execution._verification import Verification
from rogue.execution._whereabouts import bounded
from rogue.outcomes import CAMERA, Arrival, Outcome, StepOutcome, Thing, Trouble
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

HINDERED = frozenset(
    {NavigationFailure.BUMP, NavigationFailure.NO_PROGRESS, NavigationFailure.LOST}
)
"""Failures of navigation that another try may cure."""

LET_ME_OUT = "I am shut in. Please open the door."


def go_to(
    room: str, patience: Patience, verification: Verification, *, start: str | None = None
) -> Procedure:
    """GOTO-PICKUP-LOC and GOTO-DELIVER-LOC: drive to a room and make sure that it is the one.

    ``start`` is the room where the robot is, None if it is in none.
    """
    arrivals: list[Arrival] = []
    arrival: Arrival | None = None
    drive = Outcome()
    for _ in range(patience.tries):
        drive = yield from _drive(room)
        if drive.failure in BLOCKED:
            return (yield from _blocked(room, drive, start, arrivals))
        arrival = yield from _arrived_at(room, drive, patience, verification)
        arrivals += [arrival] if arrival is not None else []
        if arrival is not None and arrival.room == room:
            yield Tell(trace.completed_line("GOTO-LOCATION", room.upper()))
            yield Tell("")
            return _ended(arrivals, "done", room=room)
    yield from _failed("GOTO-LOCATION", room.upper())
    if arrival is not None and arrival.room is not None:
        reason = f"the robot is at {arrival.room}"
        return _ended(arrivals, "elsewhere", room=arrival.room, reason=reason)
    trouble = Trouble.UNABLE if drive.failed else Trouble.UNSURE
    trouble = Trouble.HINDERED if drive.failure in HINDERED else trouble
    why = drive.reason if drive.failed else "unverified: this may be another place"
    reason = f"cannot get to {room} in {patience.tries} tries, {why}"
    return _ended(arrivals, "failed", reason=reason, trouble=trouble)


def acquire(
    room: str, thing: Thing, phrase: str, patience: Patience, verification: Verification
) -> Procedure:
    """ACQUIRE-ITEM: have somebody put the item on the tray; nobody is asked for one that is there.

    ``thing`` is (user, item), ``phrase`` how the robot calls it.
    """
    moved = yield from _moved_from(room, patience, verification)
    if moved is not None:
        return moved
    if not (yield from _is_on_tray(thing)):
        answer = yield from _ask_placing(room, thing, phrase, patience)
        given = not answer.failed and typed(answer) == YES
        seen = answer.failure == NO_ANSWER and (yield from _is_on_tray(thing))
        if not given and not seen:
            yield from _failed("ACQUIRE-ITEM", f'"{phrase}"')
            return _refused("acquire-item", room, answer)
    yield Tell(trace.completed_line("ACQUIRE-ITEM", f'"{phrase}"'))
    yield Tell("")
    return StepOutcome(kind="done", room=room, placed=(thing,))


def deliver(
    room: str, thing: Thing, phrase: str, patience: Patience, verification: Verification
) -> Procedure:
    """DELIVER-ITEM: have somebody take the item from the tray, if it is still there.

    ``thing`` is (user, item), ``phrase`` how the robot calls it.
    """
    moved = yield from _moved_from(room, patience, verification)
    if moved is not None:
        return moved
    if not (yield from _is_on_tray(thing)):
        return (yield from _missing(room, thing, phrase))
    answer = yield from _ask_taking(room, thing, phrase, patience)
    taken = not answer.failed and typed(answer) == YES
    gone = not taken and not (yield from _is_on_tray(thing))
    if taken or (gone and answer.failure == NO_ANSWER):
        yield Tell(trace.completed_line("DELIVER-ITEM", f'"{phrase}"'))
        yield Tell("")
        return StepOutcome(kind="done", room=room, gone=(thing,))
    if gone:
        return (yield from _missing(room, thing, phrase))
    yield from _failed("DELIVER-ITEM", f'"{phrase}"')
    return _refused("deliver-item", room, answer)


def recharge(x: float, y: float, charge: float) -> Procedure:
    """RECHARGE: stand at the charger, at (x, y) in metres, until the battery is so full, 0 to 1."""
    yield Tell(trace.remark("The battery is low; going to the charger."))
    outcome = yield from _navigate(100.0 * x, 100.0 * y)
    if not outcome.failed:
        outcome = yield AwaitCharge(charge)
    if not outcome.failed:
        yield Tell(trace.completed_line("RECHARGE", f"{charge:.0%}"))
        yield Tell("")
        return StepOutcome(kind="done")
    yield Tell(trace.remark(outcome.reason))
    yield from _failed("RECHARGE", f"{charge:.0%}")
    return StepOutcome(kind="failed", reason=outcome.reason, trouble=Trouble.UNABLE)


def _drive(room: str) -> Part[Outcome]:
    """Navigate to the room."""
    found = yield Locate(room)
    if found.failed:
        return found
    location = RoomLocation.model_validate(found.value)
    return (yield from _navigate(location.x, location.y))


def _navigate(x: float, y: float) -> Part[Outcome]:
    """Navigate to a map location, in map units."""
    for line in trace.navigate_lines(x, y):
        yield Tell(line)
    outcome = yield Perform(NavigateToGoal(x=x, y=y))
    word = "FAILED" if outcome.failed else "ACHIEVED"
    yield Tell(trace.action_line("NAVIGATE-TO-GOAL", word))
    if outcome.failed:
        yield Tell(trace.remark(outcome.reason))
    yield Tell("")
    return outcome


def _blocked(
    room: str, drive: Outcome, start: str | None, arrivals: Sequence[Arrival]
) -> Procedure:
    """There is no way to a room; whoever is by may open the door behind which the robot is."""
    shut_in = start is not None and drive.value.get("door") == start != room
    if shut_in:
        yield from say(LET_ME_OUT)
    yield from _failed("GOTO-LOCATION", room.upper())
    reason = f"cannot get out of {start}" if shut_in else f"cannot get to {room}"
    return _ended(
        arrivals,
        "failed",
        room=start if shut_in else None,
        reason=f"{reason}, {drive.reason}",
        trouble=Trouble.SHUT_IN if shut_in else Trouble.BLOCKED,
    )


def _ended(
    arrivals: Sequence[Arrival],
    kind: Literal["done", "elsewhere", "failed"],
    *,
    room: str | None = None,
    reason: str | None = None,
    trouble: Trouble | None = None,
) -> StepOutcome:
    found = tuple(arrivals)
    return StepOutcome(kind=kind, room=room, reason=reason, trouble=trouble, arrivals=found)


def _arrived_at(
    room: str, drive: Outcome, patience: Patience, verification: Verification
) -> Part[Arrival | None]:
    """What is found of where the robot stands after a drive; None where that is not asked.

    The navigator is told what it did not know.
    """
    if drive.failed and drive.failure != NavigationFailure.LOST:
        return None
    if not drive.failed:
        yield Tell(trace.verifying_line(room))
    arrival = yield from verification.place(None if drive.failed else room, patience)
    if arrival.room is None:
        return arrival
    expected = arrival.room == room and not drive.failed
    if expected and (not verification.looks_again or (yield from _is_believed(room))):
        if arrival.by == CAMERA:
            yield Perform(NoticeLandmark(room=room, confidence=bounded(arrival.sure)))
        return arrival
    known = yield from _tell_navigator(arrival.room)
    return arrival if known else Arrival()


def _tell_navigator(room: str) -> Part[bool]:
    """Tell the navigator where it is; false when its map has no such room."""
    position = yield Perform(SetPosition(room=room))
    if position.failed:
        yield Tell(trace.remark(position.reason))
        return False
    yield Tell(trace.remark(f"The robot is at {room.upper()}."))
    yield Tell("")
    return True


def _is_believed(room: str) -> Part[bool]:
    """Whether the navigator believes to be at a room; one that does not answer may."""
    belief = yield Believe()
    return belief.failed or Position.model_validate(belief.value).room == room


def _moved_from(
    room: str, patience: Patience, verification: Verification
) -> Part[StepOutcome | None]:
    """Make sure that the robot is still where it arrived; None when it is."""
    if not verification.looks_again or (yield from _is_believed(room)):
        return None
    arrival = yield from _arrived_at(room, Outcome(), patience, verification)
    found = arrival.room if arrival is not None else None
    if found == room:
        return None
    reason = f"the robot is not at {room} any more"
    return StepOutcome(kind="failed", room=found, reason=reason, trouble=Trouble.MISTAKEN)


def _is_on_tray(thing: Thing) -> Part[bool]:
    tray = yield CheckTray(*thing)
    return bool(tray.value["on_tray"])


def _missing(room: str, thing: Thing, phrase: str) -> Part[StepOutcome]:
    reason = f"{phrase} is not on the tray any more"
    yield Tell(trace.remark(f"{reason}."))
    yield from _failed("DELIVER-ITEM", f'"{phrase}"')
    return StepOutcome(
        kind="failed", room=room, reason=reason, trouble=Trouble.MISTAKEN, gone=(thing,)
    )


def _refused(action: str, room: str, answer: Outcome) -> StepOutcome:
    """What came of a hand-over for which nobody was there, or to which somebody said no."""
    if not answer.failed:
        trouble, why = Trouble.IMPOSSIBLE, "impossible: the person there said so"
    else:
        nobody = answer.failure == NO_ANSWER
        trouble, why = Trouble.NOBODY if nobody else Trouble.UNABLE, answer.reason
    reason = f"{action} at {room}, {why}"
    return StepOutcome(kind="failed", room=room, reason=reason, trouble=trouble)


def _ask_placing(room: str, thing: Thing, phrase: str, patience: Patience) -> Part[Outcome]:
    question = Ask(
        question=f"Are you finished placing {phrase} on my tray? (y/i(mpossible))",
        choices=("y", "i"),
        about="placing",
        room=room,
        user=thing[0],
        item=thing[1],
        timeout=patience.answer_within,
    )
    request = f"Please place {phrase} on my tray."
    return (yield from ask((request, WHEN_FINISHED), question, patience))


def _ask_taking(room: str, thing: Thing, phrase: str, patience: Patience) -> Part[Outcome]:
    question = Ask(
        question=f"Are you finished taking {phrase} from my tray? (y/i(mpossible))",
        choices=("y", "i"),
        about="taking",
        room=room,
        user=thing[0],
        item=thing[1],
        timeout=patience.answer_within,
    )
    request = f"Please take {phrase} from my tray."
    return (yield from ask((request, WHEN_FINISHED), question, patience))


def _failed(action: str, *arguments: str) -> Part[None]:
    yield Tell(trace.failed_line(action, *arguments))
    yield Tell("")
