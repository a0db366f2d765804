"""The people in the office, who know where the robot really is: what they answer, and when."""

from __future__ import annotations

from collections.abc import MutableMapping, Sequence
from dataclasses import dataclass

from xavier_sim.messages import Ask, Occupant, TrueLocation
from xavier_sim.noise import stream

QUICKEST, SLOWEST = 2.0, 8.0
"""Seconds that a person takes to answer, at least and at most."""

AWAY_FOR = 1800.0
"""Seconds for which people are in or out: they come and go at the half hour."""

ERRAND = ("pickup", "deliver")
"""Questions that go to the user of an item, wherever the robot is."""


@dataclass(frozen=True, kw_only=True)
class Habits:
    """How difficult people are; all are shares from 0 to 1.

    ``silence`` of questions are not answered, ``silent_people`` never answer, ``away`` of the
    time somebody is out of their room, ``missing_items`` are not where they are to be picked up.
    """

    silence: float = 0.0
    silent_people: float = 0.0
    away: float = 0.0
    missing_items: float = 0.0


@dataclass(frozen=True)
class Reaction:
    """How somebody takes a question: after how many seconds they answer, None for not at all."""

    delay: float | None


class People:
    """Simulated people, one in each room, and passers-by everywhere else.

    Who is silent, what is missing and how long an answer takes depends on seed and question, not
    on the time or the order of asking; who is in depends on the seed and the half hour.

    Args:
        seed: of their habits.
        habits: how difficult they are.
        sent: rooms whose people were sent out (False) or in (True); kept by the caller.
    """

    def __init__(
        self, *, seed: int, habits: Habits, sent: MutableMapping[str, bool] | None = None
    ) -> None:
        self._seed, self._habits = seed, habits
        self._sent: MutableMapping[str, bool] = {} if sent is None else sent

    def react(self, question: str, time_asked: int) -> Reaction:
        """How they take a question that is asked for the ``time_asked``-th time."""
        draw = stream(self._seed, f"{time_asked} {question}")
        silent = draw.random() < self._habits.silence
        return Reaction(None if silent else float(draw.uniform(QUICKEST, SLOWEST)))

    def occupant(self, room: str, now: float) -> Occupant:
        """Whoever works in a room, at a time in seconds since the epoch."""
        return Occupant(room=room, present=self._is_in(room, now), answers=self._answers(room))

    def send(self, room: str, *, present: bool) -> None:
        """Send the one who works in a room in or out, until they are sent again."""
        self._sent[room] = present

    def is_heard(self, ask: Ask, really: TrueLocation, now: float) -> bool:
        """Whether a question reaches somebody who ever answers."""
        if ask.about in ERRAND:
            return ask.user is None or self._answers(ask.user)
        room = really.room
        return room is None or (self._is_in(room, now) and self._answers(room))

    def has_item(self, room: str, user: str, item: str) -> bool:
        """Whether an item is where it is to be picked up."""
        return self._draw(f"missing {room} {user} {item}") >= self._habits.missing_items

    def room_for(self, ask: Ask, rooms: Sequence[str]) -> str:
        """The room that the user of an item has in mind for its pickup or delivery."""
        known = ask.choices or tuple(rooms)
        share = self._draw(f"{ask.about} {ask.user} {ask.item}")
        return known[int(share * len(known))] if known else "nowhere"

    def _is_in(self, room: str, now: float) -> bool:
        if room in self._sent:
            return self._sent[room]
        return self._draw(f"away {room} {int(now // AWAY_FOR)}") >= self._habits.away

    def _answers(self, name: str) -> bool:
        return self._draw(f"silent {name}") >= self._habits.silent_people

    def _draw(self, what: str) -> float:
        return float(stream(self._seed, what).random())


def truthful_answer(ask: Ask, really: TrueLocation, *, is_there: bool = True) -> str:
    """What somebody types who sees where the robot stands, and whether the item is there."""
    here = ask.room is None or really.room == ask.room
    match ask.about:
        case "place":
            wanted = "y" if here else "n"
        case "placing" | "taking":
            wanted = "y" if here and is_there else "i"
        case "where":
            return really.room or really.space or "nowhere"
        case _:
            wanted = "y"
    return wanted if not ask.choices or wanted in ask.choices else ask.choices[-1]
