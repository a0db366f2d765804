"""Durable execution of one step: whatever was done once is not done again.

Each effect of a procedure has a position, and each task the id ``<store>-<step>.<position>``.
Outcomes are kept as they come. A step that is run again after a crash reads the outcomes that
were kept; a task that was submitted and whose outcome was not kept is submitted again under the
same id, so that central gives its recorded outcome or lets us wait for it on.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterable

from rogue.execution._effects import (
    AwaitCharge,
    Believe,
    CheckTray,
    Effect,
    Locate,
    Look,
    Perform,
    Procedure,
    Tell,
    Urgency,
)
from rogue.execution._robot import Robot
from rogue.memory import Step, Store
from rogue.outcomes import NOTHING, Outcome, StepOutcome

Teller = Callable[[str, int, int], Awaitable[None]]
"""Prints a line, told the number of its step and its position in it."""

AFTERWARDS = 100_000
"""Position of the first line that is told of a step once its procedure has ended."""


class StepRunner:
    """Runs procedures against a robot, with a store that remembers how far they came."""

    def __init__(self, robot: Robot, store: Store, identity: str, tell: Teller) -> None:
        self._robot = robot
        self._store = store
        self._identity = identity
        self._tell = tell

    async def run(self, step: Step, procedure: Procedure, urgency: Urgency) -> StepOutcome:
        """Run a procedure to its end, from where it was before a crash if there was one."""
        known = await self._store.outcomes(step)
        outcome: Outcome | None = None
        position = 0
        while True:
            effect = _next(procedure, outcome)
            if isinstance(effect, StepOutcome):
                return effect
            position += 1
            kept = known.get(position)
            outcome = kept or await self._carry_out(step, position, effect, urgency)

    async def abandon(self, step: Step, procedure: Procedure, reason: str) -> None:
        """Stop what a step that is not gone on with may have under way in the task tree."""
        known = await self._store.outcomes(step)
        outcome: Outcome | None = None
        position = 0
        while not isinstance(effect := _next(procedure, outcome), StepOutcome):
            position += 1
            outcome = NOTHING if isinstance(effect, Tell) else known.get(position)
            if outcome is None:
                if isinstance(effect, Perform):
                    await self._robot.kill(self._task_id(step, position), reason)
                return

    async def tell_after(self, step: Step, lines: Iterable[str]) -> None:
        """Tell what follows from a step; what was told before a crash is not told again."""
        for position, line in enumerate(lines, AFTERWARDS):
            await self._tell(line, step.number, position)

    async def _carry_out(
        self, step: Step, position: int, effect: Effect, urgency: Urgency
    ) -> Outcome:
        if isinstance(effect, Tell):
            await self._tell(effect.line, step.number, position)
            return NOTHING
        outcome = await self._answer(step, position, effect, urgency)
        await self._store.keep_outcome(step, position, outcome)
        return outcome

    async def _answer(self, step: Step, position: int, effect: Effect, urgency: Urgency) -> Outcome:
        match effect:
            case Locate():
                return await self._robot.locate(effect)
            case Believe():
                return await self._robot.believe(effect)
            case Look():
                return await self._robot.look(effect)
            case CheckTray(user=user, item=item):
                facts = await self._store.facts()
                return Outcome(value={"on_tray": (user, item) in facts.tray})
            case AwaitCharge():
                return await self._robot.await_charge(effect)
            case Tell():
                return NOTHING
            case Perform(message=message):
                return await self._robot.perform(self._task_id(step, position), message, urgency)

    def _task_id(self, step: Step, position: int) -> str:
        return f"{self._identity}-{step.number}.{position}"


def _next(procedure: Procedure, outcome: Outcome | None) -> Effect | StepOutcome:
    """The next effect of a procedure, or what it came to."""
    try:
        # A generator that has not started takes only None.
        return next(procedure) if outcome is None else procedure.send(outcome)
    except StopIteration as stop:
        result: StepOutcome = stop.value
        return result
