"""The people in the office, who know where the robot really is: what they answer, and when."""

from __future__ import annotations

from dataclasses import dataclass

from xavier_sim.messages import Ask, TrueLocation
from xavier_sim.noise import stream

QUICKEST, SLOWEST = 2.0, 8.0
"""Seconds that a person takes to answer, at least and at most."""


@dataclass(frozen=True)
class Reaction:
    """How somebody takes a question: after how many seconds they answer, None for not at all."""

    delay: float | None


class People:
    """Simulated people; what they do depends on seed and question, not on the time of asking.

    Args:
        seed: of their habits.
        silence: the share of questions that nobody answers, 0 to 1.
    """

    def __init__(self, *, seed: int, silence: float) -> None:
        self._seed, self._silence = seed, silence

    def react(self, question: str, time_asked: int) -> Reaction:
        """How they take a question that is asked for the ``time_asked``-th time."""
        draw = stream(self._seed, f"{time_asked} {question}")
        silent = draw.random() < self._silence
        return Reaction(None if silent else float(draw.uniform(QUICKEST, SLOWEST)))


def truthful_answer(ask: Ask, really: TrueLocation) -> str:
    """What somebody types who sees where the robot stands."""
    here = ask.room is None or really.room == ask.room
    match ask.about:
        case "place":
            wanted = "y" if here else "n"
        case "placing" | "taking":
            wanted = "y" if here else "i"
        case "where":
            return really.room or really.space or "nowhere"
        case _:
            wanted = "y"
    return wanted if not ask.choices or wanted in ask.choices else ask.choices[-1]


def item_action(ask: Ask, answer: str) -> str | None:
    """What an answer says was done with an item: ``placed``, ``taken``, or None for nothing."""
    actions = {"placing": "placed", "taking": "taken"}
    return actions.get(ask.about) if answer == "y" and ask.user and ask.item else None
