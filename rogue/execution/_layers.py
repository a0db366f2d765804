"""The layers in which an arrival is verified, and what each of them can say.

Source: Haigh & Veloso (1997), *Execution and Monitoring*: the navigator's probability, then the
camera that reads the label beside the door, then a person.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from typing import Protocol

from navigate.messages import Position, Sight
from rogue import trace
from rogue.execution._asking import YES, ask, typed
from rogue.execution._effects import Believe, Locate, Look, Part, Tell
from rogue.execution._patience import Patience
from rogue.execution._whereabouts import PLACES, Evidence, both, bounded, read, stated
from rogue.outcomes import BELIEF, CAMERA, PERSON
from xavier_sim.messages import Ask

AT_KEYBOARD = "Please answer on my keyboard."


@dataclass(frozen=True, slots=True)
class Doubt:
    """What is to be found out: whether the robot is at ``room``; where it is, if that is None."""

    room: str | None
    patience: Patience


class Layer(Protocol):
    """One way to find out where the robot stands. It tells the trace what it found."""

    @property
    def name(self) -> str:
        """What it is called where it is told who made sure."""

    def look(self, doubt: Doubt) -> Part[Evidence | None]:
        """Gather evidence; None when there is nothing to be said."""


@dataclass(frozen=True, slots=True)
class NavigatorBelief:
    """What the navigator believes, with its own confidence. One that is lost says nothing.

    Its doubts may be as wrong as it is: ``least`` is how probable the room stays that it has just
    driven to, whatever it says, so that a person can outweigh it.
    """

    least: float = 0.05
    name: str = BELIEF

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

    A plate that is not found, or is not the one that was expected, is looked for again, ``looks``
    times in all, ``pause`` seconds apart. ``unseen`` is how probable it is that a look finds no
    plate at the right door, ``blank`` at any other place. With ``heeds_belief`` a plate of
    another room counts for more where the navigator had thought it possible to be there.
    """

    looks: int = 2
    pause: float = 1.0
    unseen: float = 0.3
    blank: float = 0.7
    heeds_belief: bool = True
    name: str = CAMERA

    def look(self, doubt: Doubt) -> Part[Evidence | None]:
        """Read the plate."""
        found: list[Evidence] = []
        expected: dict[str, float] = {}
        for number in range(self.looks):
            seen = yield Look(after=self.pause if number else 0.0)
            if seen.failed:
                yield Tell(trace.remark(f"The camera sees nothing, {seen.reason}."))
                break
            sight = Sight.model_validate(seen.value)
            room = sight.plate.strip().lower() if sight.plate else None
            yield Tell(trace.remark(_told(room, sight.confidence)))
            found += self._evidence(room, sight.confidence, doubt)
            if room is not None and room == doubt.room:
                break
            if room is not None and doubt.room is not None and self.heeds_belief:
                expected[room] = _share(sight)
        return reduce(both, found, Evidence(expected, 1.0)) if found else None

    def _evidence(self, room: str | None, confidence: float, doubt: Doubt) -> list[Evidence]:
        if room is not None:
            return [read(room, confidence)]
        return [Evidence({doubt.room: self.unseen}, self.blank)] if doubt.room else []


def _told(room: str | None, confidence: float) -> str:
    if room is None:
        return "The camera sees no door plate."
    return f"The camera reads {room.upper()} ({confidence:.3f})."


def _share(sight: Sight) -> float:
    """How much more the navigator believes in the room of a plate than in any of the others."""
    others = (1.0 - bounded(sight.position.confidence)) / (PLACES - 1)
    return max(1.0, sight.expected / others)


@dataclass(frozen=True, slots=True)
class Bystander:
    """What a person says: whether this is the room and, if it is not, which one it is.

    ``honest`` is how probable a "yes" is at the right door, ``mistaken`` at any other, and
    ``named`` how probable it is that a person names the room rightly.
    """

    honest: float = 0.99
    mistaken: float = 0.0005
    named: float = 0.995
    name: str = PERSON

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
