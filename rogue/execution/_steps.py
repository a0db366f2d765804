"""Durable execution of one step: whatever was done once is not done again.

Each effect of a procedure has a position, and each task the id ``<store>-<step>.<position>``.
Outcomes are kept as they come. A step that is run again after a crash reads the outcomes that
were kept; a task that was submitted and whose outcome was not kept is submitted again under the
same id, so that central gives its recorded outcome or lets us wait for it on.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from rogue.execution._effects import Believe, Effect, Locate, Look, Pause, Procedure, Tell
from rogue.execution._robot import Robot
from rogue.memory import Step, Store
from rogue.outcomes import NOTHING, Outcome, StepOutcome

Teller = Callable[[str, int, int], Awaitable[None]]
"""Prints a line, told the number of its step and its position in it."""


class StepRunner:
    """Runs procedures against a robot, with a store that remembers how far they came."""

    def __init__(self, robot: Robot, store: Store, identity: str, tell: Teller) -> None:
        self._robot = robot
        self._store = store
        self._identity = identity
        self._tell = tell

    async def run(self, step: Step, procedure: Procedure) -> StepOutcome:
        """Run a procedure to its end, from where it was before a crash if there was one."""
        known = await self._store.outcomes(step)
        outcome: Outcome | None = None
        position = 0
        while True:
            try:
                # A generator that has not started takes only None.
                effect = next(procedure) if outcome is None else procedure.send(outcome)
            except StopIteration as stop:
                result: StepOutcome = stop.value
                return result
            position += 1
            outcome = known.get(position) or await self._carry_out(step, position, effect)

    async def _carry_out(self, step: Step, position: int, effect: Effect) -> Outcome:
        if isinstance(effect, Tell):
            await self._tell(effect.line, step.number, position)
            return NOTHING
        outcome = await self._answer(step, position, effect)
        await self._store.keep_outcome(step, position, outcome)
        return outcome

    async def _answer(self, step: Step, position: int, effect: Effect) -> Outcome:
        match effect:
            case Locate():
                return await self._robot.locate(effect)
            case Believe():
                return await self._robot.believe(effect)
            case Look():
                return await self._robot.look(effect)
            case Pause():
                return await self._robot.pause(effect)
            case Tell():
                return NOTHING
            case _:
                task_id = f"{self._identity}-{step.number}.{position}"
                return await self._robot.perform(task_id, effect.message)
