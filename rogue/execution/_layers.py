"""The layers in which an arrival is verified, and what each of them can say.

Source: Haigh & Veloso (1997), *Execution and Monitoring*: the navigator's probability, then the
camera that reads the label beside the door, then a person.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from navigate.messages import Position
from rogue import trace
from rogue.execution._asking import YES, ask, typed
from rogue.execution._effects import Believe, Locate, Look, Part, Tell
from rogue.execution._patience import Patience
from rogue.execution._whereabouts import Evidence, both, read, stated
from xavier_sim.messages import Ask, PlateReading

AT_KEYBOARD = "Please answer on my keyboard."


@dataclass(frozen=True, slots=True)
class Doubt:
    """What is to be found out: whether the robot is at ``room``; where it is, if that is None."""

    room: str | None
    patience: Patience


class Layer(Protocol):
    """One way to find out where the robot stands. It tells the trace what it found."""

    def look(self, doubt: Doubt) -> Part[Evidence | None]:
        """Gather evidence; None when there is nothing to be said."""


@dataclass(frozen=True, slots=True)
class NavigatorBelief:
    """What the navigator believes, with its own confidence. One that is lost says nothing.

    Its doubts may be as wrong as it is: ``least`` is how probable the room stays that it has just
    driven to, whatever it says, so that a person can outweigh it.
    """

    least: float = 0.05

    def look(self, doubt: Doubt) -> Part[Evidence | None]:
        """Ask the navigator."""
        if doubt.room is None:
            return None
        belief = yield Believe()
        if belief.failed:
            yield Tell(trace.remark(f"The navigator says nothing, {belief.reason}."))
            return None
        position = Position.model_validate(belief.value)
        if position.room is None:
            yield Tell(trace.remark("The navigator believes to be at no room."))
            return stated(doubt.room, self.least)
        place = f"{position.room.upper()} ({position.confidence:.3f})"
        yield Tell(trace.remark(f"The navigator believes to be at {place}."))
        return stated(position.room, max(position.confidence, self.least))


@dataclass(frozen=True, slots=True)
class DoorPlate:
    """What the camera reads beside the door.

    ``unseen`` is how probable it is that it finds no plate at the door of a room; elsewhere it
    hardly ever finds one.
    """

    unseen: float = 0.1

    def look(self, doubt: Doubt) -> Part[Evidence | None]:
        """Read the plate."""
        seen = yield Look()
        if seen.failed:
            yield Tell(trace.remark(f"The camera sees nothing, {seen.reason}."))
            return None
        plate = PlateReading.model_validate(seen.value)
        if plate.text is None:
            yield Tell(trace.remark("The camera sees no door plate."))
            return Evidence({doubt.room: self.unseen}, 0.5) if doubt.room else None
        room = plate.text.strip().lower()
        reads = f"{room.upper()} ({plate.confidence:.3f})"
        yield Tell(trace.remark(f"The camera reads {reads}."))
        return read(room, plate.confidence)


@dataclass(frozen=True, slots=True)
class Bystander:
    """What a person says: whether this is the room and, if it is not, which one it is.

    ``honest`` is how probable a "yes" is at the right door, ``mistaken`` at any other, and
    ``named`` how probable it is that a person names the room rightly.
    """

    honest: float = 0.99
    mistaken: float = 0.0005
    named: float = 0.995

    def look(self, doubt: Doubt) -> Part[Evidence | None]:
        """Ask whoever is there."""
        if doubt.room is None:
            named = yield from self._name(doubt.patience)
            return None if named is None else read(named, self.named)
        answer = yield from self._confirm(doubt.room, doubt.patience)
        if answer is None:
            return None
        if answer:
            return Evidence({doubt.room: self.honest}, self.mistaken)
        denied = Evidence({doubt.room: 1.0 - self.honest}, 1.0 - self.mistaken)
        named = yield from self._name(doubt.patience)
        return denied if named is None else both(denied, read(named, self.named))

    def _confirm(self, room: str, patience: Patience) -> Part[bool | None]:
        """Whether somebody says yes; None when nobody says anything."""
        words = f"Am I really at the door of room {room.upper()}?"
        question = Ask(
            question=f"{words} (y/n)",
            choices=("y", "n"),
            about="place",
            room=room,
            timeout=patience.answer_within,
        )
        answer = yield from ask((words, AT_KEYBOARD), question, patience)
        return None if answer.failed else typed(answer) == YES

    def _name(self, patience: Patience) -> Part[str | None]:
        """The room that somebody names, once it is one of the map's."""
        words = "Which room am I at?"
        question = Ask(question=words, about="where", timeout=patience.answer_within)
        for _ in range(patience.asks):
            answer = yield from ask((words, AT_KEYBOARD), question, patience)
            if answer.failed:
                return None
            room = typed(answer).strip().lower()
            known = yield Locate(room)
            if not known.failed:
                return room
            yield Tell(trace.remark(known.reason))
        return None
