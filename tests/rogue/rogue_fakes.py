"""A robot that answers as a test tells it to."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from navigate.messages import NavigateToGoal, SetPosition
from rogue.effects import (
    Believe,
    Effect,
    Locate,
    Outcome,
    Pause,
    Perform,
    Procedure,
    StepOutcome,
    TaskOfRobot,
    Tell,
)
from xavier_sim.messages import Ask, Say

PLACES = {"r-5303": (567.0, 2316.5), "r-5305": (567.0, 2676.2), "r-5313": (567.0, 4115.0)}

NO_ANSWER = Outcome(failure="no_answer", text="nobody answered within 60 s")


def typed(answer: str) -> Outcome:
    return Outcome(value={"answer": answer, "time": 0.0})


def failed(name: str) -> Outcome:
    return Outcome(failure=name, text=f"it was {name}")


def position(room: str | None, deviation: float) -> Outcome:
    zero = {"x": 0.0, "y": 0.0, "theta": 0.0, "heading_deviation": 0.0, "time": 0.0}
    return Outcome(value={**zero, "deviation": deviation, "room": room})


@dataclass
class ScriptedRobot:
    """Drives succeed and people say yes, but for what the scripts hold, first come first used."""

    drives: list[Outcome] = field(default_factory=list)
    answers: list[Outcome] = field(default_factory=list)
    belief: Outcome = field(default_factory=lambda: position(None, 9.0))
    performed: list[TaskOfRobot] = field(default_factory=list)
    ids: list[str] = field(default_factory=list)
    pauses: list[float] = field(default_factory=list)

    def outcome(self, effect: Effect) -> Outcome:
        """What comes of an effect."""
        match effect:
            case Locate(room):
                x, y = PLACES[room]
                return Outcome(value={"room": room, "x": x, "y": y})
            case Believe():
                return self.belief
            case Pause(seconds):
                self.pauses.append(seconds)
                return Outcome()
            case Perform(message):
                return self.act(message)
            case Tell():
                return Outcome()

    def act(self, message: TaskOfRobot) -> Outcome:
        self.performed.append(message)
        match message:
            case Say(text=text):
                return Outcome(value={"text": text, "time": 0.0})
            case Ask():
                return self.answers.pop(0) if self.answers else typed("y")
            case SetPosition(room=room) if room not in PLACES:
                return failed("unknown_room")
            case NavigateToGoal():
                return self.drives.pop(0) if self.drives else Outcome()
        return Outcome()

    def count(self, kind: type[TaskOfRobot]) -> int:
        """How often a kind of task was carried out."""
        return sum(isinstance(message, kind) for message in self.performed)

    async def locate(self, effect: Locate) -> Outcome:
        return self.outcome(effect)

    async def believe(self, effect: Believe) -> Outcome:
        return self.outcome(effect)

    async def pause(self, effect: Pause) -> Outcome:
        return self.outcome(effect)

    async def perform(self, task_id: str, message: TaskOfRobot) -> Outcome:
        self.ids.append(task_id)
        return self.act(message)


def play(
    procedure: Procedure, answer: Callable[[Effect], Outcome]
) -> tuple[StepOutcome, list[str]]:
    """Run a procedure; gives its outcome and the lines that it printed."""
    lines: list[str] = []
    effect = next(procedure)
    while True:
        if isinstance(effect, Tell):
            lines.append(effect.line)
        try:
            effect = procedure.send(answer(effect))
        except StopIteration as stop:
            return stop.value, lines


def section(lines: Iterable[str], first: str, last: str) -> list[str]:
    """The lines from the first that contains ``first`` to the next that contains ``last``."""
    found = list(lines)
    start = next(i for i, line in enumerate(found) if first in line)
    end = next(i for i, line in enumerate(found[start:], start) if last in line)
    return found[start : end + 1]
