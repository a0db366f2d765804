"""How each operator of the office domain is carried out and its outcome verified.

The words are those of Figure 6 of Haigh & Veloso (1996); the retries are those of Haigh & Veloso
(1998), section on monitoring: three tries, then the planner is told where the robot is.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from typing import TypeVar

from navigate.messages import NavigateToGoal, NavigationFailure, Position, RoomLocation, SetPosition
from rogue import trace
from rogue.execution._effects import (
    Believe,
    Effect,
    Locate,
    Pause,
    Perform,
    Procedure,
    Tell,
)
from rogue.outcomes import NOTHING, Outcome, StepOutcome
from xavier_sim.messages import Ask, Say, Typed

T = TypeVar("T")
Part = Generator[Effect, Outcome, T]
"""A part of a procedure that comes to a ``T``."""

YES = "y"
NO_ANSWER = "no_answer"
AT_KEYBOARD = "Please answer on my keyboard."
WHEN_FINISHED = "Please indicate on my keyboard when you are finished."

BLOCKED = frozenset(
    {
        NavigationFailure.DOOR_BLOCKED,
        NavigationFailure.CORRIDOR_BLOCKED,
        NavigationFailure.NO_ROUTE,
    }
)
"""Failures of navigation that time may cure."""


@dataclass(frozen=True, slots=True)
class Patience:
    """How often and how long a procedure tries before it gives up.

    ``pause`` and ``answer_within`` are seconds on the module's clock. A position whose standard
    deviation is at most ``sure`` metres is believed when nobody is there to ask.
    """

    asks: int = 3
    tries: int = 3
    blocked_tries: int = 5
    pause: float = 60.0
    answer_within: float = 60.0
    sure: float = 0.5


def go_to(room: str, patience: Patience) -> Procedure:
    """GOTO-PICKUP-LOC and GOTO-DELIVER-LOC: drive to a room and make sure that it is the one."""
    found: str | None = None
    why = "not tried"
    for _ in range(patience.tries):
        drive = yield from _drive(room, patience)
        if drive.failure in BLOCKED:
            yield Tell(trace.failed_line("GOTO-LOCATION", room.upper()))
            yield Tell("")
            return StepOutcome(kind="failed", reason=f"cannot get to {room}, {drive.reason}")
        if not drive.failed and (yield from _is_at(room, patience)):
            yield Tell(trace.completed_line("GOTO-LOCATION", room.upper()))
            yield Tell("")
            return StepOutcome(kind="done", room=room)
        why = drive.reason if drive.failed else "unverified: this is another place"
        knows = drive.failed and drive.failure != NavigationFailure.LOST
        found = None if knows else (yield from _relocate(patience))
    yield Tell(trace.failed_line("GOTO-LOCATION", room.upper()))
    yield Tell("")
    if found is not None:
        return StepOutcome(kind="elsewhere", room=found, reason=f"the robot is at {found}")
    reason = f"cannot get to {room} in {patience.tries} tries, {why}"
    return StepOutcome(kind="failed", reason=reason)


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


def _is_at(room: str, patience: Patience) -> Part[bool]:
    """Ask whoever is there; if nobody is, believe a navigator that is sure."""
    yield Tell(trace.verifying_line(room))
    question = f"Am I really at the door of room {room.upper()}?"
    ask = Ask(
        question=f"{question} (y/n)",
        choices=("y", "n"),
        about="place",
        room=room,
        timeout=patience.answer_within,
    )
    answer = yield from _ask((question, AT_KEYBOARD), ask, patience)
    if not answer.failed:
        return Typed.model_validate(answer.value).answer == YES
    belief = yield Believe()
    if belief.failed:
        return False
    position = Position.model_validate(belief.value)
    sure = position.room == room and position.deviation <= patience.sure
    judgement = "is sure to be there" if sure else "is not sure to be there"
    spread = f"within {position.deviation:.2f} m"
    yield Tell(trace.remark(f"Nobody answered; the navigator {judgement} ({spread})."))
    return sure


def _relocate(patience: Patience) -> Part[str | None]:
    """Ask where the robot is, and tell the navigator; None when nobody can say."""
    question = "Which room am I at?"
    ask = Ask(question=question, about="where", timeout=patience.answer_within)
    for _ in range(patience.asks):
        answer = yield from _ask((question, AT_KEYBOARD), ask, patience)
        if answer.failed:
            return None
        room = Typed.model_validate(answer.value).answer.strip().lower()
        position = yield Perform(SetPosition(room=room))
        if not position.failed:
            yield Tell(trace.remark(f"The robot is at {room.upper()}."))
            yield Tell("")
            return room
        yield Tell(trace.remark(position.reason))
    return None


def _hand_over(
    action: str, request: str, question: Ask, phrase: str, patience: Patience
) -> Procedure:
    answer = yield from _ask((request, WHEN_FINISHED), question, patience)
    if not answer.failed and Typed.model_validate(answer.value).answer == YES:
        yield Tell(trace.completed_line(action, f'"{phrase}"'))
        yield Tell("")
        return StepOutcome(kind="done", room=question.room)
    reason = answer.reason if answer.failed else "impossible: the person there said so"
    yield Tell(trace.failed_line(action, f'"{phrase}"'))
    yield Tell("")
    return StepOutcome(
        kind="failed", room=question.room, reason=f"{action.lower()} at {question.room}, {reason}"
    )


def _ask(say: tuple[str, ...], ask: Ask, patience: Patience) -> Part[Outcome]:
    """Say what is wanted and wait for an answer, again while nobody answers."""
    answer = NOTHING
    for _ in range(patience.asks):
        for sentence in say:
            yield Tell(trace.say_line(sentence))
            said = yield Perform(Say(text=sentence))
            if said.failed:
                yield Tell(trace.remark(said.reason))
        yield Tell("")
        answer = yield Perform(ask)
        if answer.failure != NO_ANSWER:
            break
        yield Tell(trace.prompt_line(ask.question, "(no answer)"))
    if answer.failed:
        yield Tell(trace.remark(answer.reason))
    else:
        typed = Typed.model_validate(answer.value)
        yield Tell(trace.prompt_line(ask.question, typed.answer))
    return answer
