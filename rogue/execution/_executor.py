"""Carrying out operators: which procedure, which requests it serves, what it changes."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Iterable, Sequence
from dataclasses import replace

from rogue.execution._effects import Procedure
from rogue.execution._patience import Patience
from rogue.execution._procedures import acquire, deliver, go_to
from rogue.execution._robot import BusRobot
from rogue.execution._steps import StepRunner
from rogue.execution._verification import Verification
from rogue.memory import Facts, Step, Store
from rogue.messages import DeliveryRequest, RequestState
from rogue.outcomes import StepOutcome
from rogue.requests import Directory, RequestBook
from tca_bus import Module

log = logging.getLogger(__name__)

GOTO_PICKUP = "goto-pickup-loc"
GOTO_DELIVER = "goto-deliver-loc"
ACQUIRE = "acquire-item"
DELIVER = "deliver-item"
RETURN = "return-item"

MOST_WRONG_ARRIVALS = 3
"""Drives for one request that may end in another room before it is given up."""


class Executor:
    """Runs one operator at a time, durably, and keeps what it changed."""

    def __init__(
        self,
        *,
        module: Module,
        store: Store,
        book: RequestBook,
        directory: Directory,
        robot: BusRobot,
        runner: StepRunner,
        patience: Patience,
        arrival: Verification,
    ) -> None:
        self._module = module
        self._store = store
        self._book = book
        self._directory = directory
        self._robot = robot
        self._runner = runner
        self._patience = patience
        self._arrival = arrival
        self._current: tuple[Step, asyncio.Task[StepOutcome]] | None = None

    async def execute(
        self, operator: str, arguments: Sequence[str], request_ids: Iterable[str]
    ) -> StepOutcome:
        """Carry out an operator for those of the requests that it serves.

        An operator that serves nobody any more fails at once, and nothing moves.
        """
        facts = await self._store.facts()
        found = (self._book.find(request_id) for request_id in request_ids)
        planned = [request for request in found if request is not None]
        served = _served(operator, arguments, planned, facts)
        if not served:
            return _unwanted(facts.room)
        begun = [self._book.as_begun(request) for request in served]
        now = self._module.clock.now()
        step = await self._store.begin_step(operator, arguments, begun, now)
        if step is None:
            return _unwanted(facts.room)
        for request, before in zip(begun, served, strict=True):
            if request != before:
                await self._book.took_effect(request)
        return await self._run(step)

    async def resume(self) -> None:
        """Bring the step to its end during which the agent was stopped, if there was one."""
        step = await self._store.open_step()
        if step is not None:
            log.info("taking up step %d, %s", step.number, step.operator)
            await self._run(step)

    def requests_changed(self) -> None:
        """Break off a drive that nobody wants any more."""
        if self._current is None:
            return
        step, task = self._current
        if step.operator in {GOTO_PICKUP, GOTO_DELIVER} and not self._wanted(step):
            running = self._robot.running
            task.cancel()
            if running is not None:
                kill = self._robot.kill(running, "nobody wants it any more")
                self._module.start(kill, name="rogue.kill")

    async def _run(self, step: Step) -> StepOutcome:
        outcome = await self._outcome(step)
        facts = _facts_after(step, outcome, await self._store.facts())
        changed = await self._changed(step, outcome, facts)
        now = self._module.clock.now()
        ended = await self._store.end_step(step, outcome, facts, now, changed=changed)
        for request in ended:
            await self._book.took_effect(request)
        return outcome

    async def _outcome(self, step: Step) -> StepOutcome:
        procedure = self._procedure(step)
        if not self._wanted(step) and step.operator in {GOTO_PICKUP, GOTO_DELIVER}:
            return _unwanted()
        task = asyncio.create_task(self._runner.run(step, procedure), name=f"step-{step.number}")
        self._current = step, task
        try:
            return await task
        except asyncio.CancelledError:
            own = asyncio.current_task()
            if own is not None and own.cancelling():
                raise
            return _unwanted()
        finally:
            self._current = None

    def _wanted(self, step: Step) -> bool:
        found = [self._book.find(request_id) for request_id in step.requests]
        served = [request for request in found if request is not None]
        if step.operator == GOTO_DELIVER:
            return any(request.destination == step.arguments[1] for request in served)
        return bool(served)

    def _procedure(self, step: Step) -> Procedure:
        if step.operator in {GOTO_PICKUP, GOTO_DELIVER}:
            return go_to(step.arguments[1], self._patience, self._arrival)
        room, user, item = step.arguments
        phrase = self._directory.phrase(user, item)
        hand_over = acquire if step.operator == ACQUIRE else deliver
        return hand_over(room, user, item, phrase, self._patience)

    async def _changed(
        self, step: Step, outcome: StepOutcome, facts: Facts
    ) -> list[DeliveryRequest]:
        """The requests that the step has ended, as they are then."""
        found = (self._book.find(request_id) for request_id in step.requests)
        served = [request for request in found if request is not None]
        if outcome.kind == "done":
            if step.operator not in {DELIVER, RETURN}:
                return []
            return [self._book.as_ended(r, RequestState.COMPLETED, None, facts) for r in served]
        if outcome.kind == "elsewhere":
            served = [r for r in served if await self._wrong_arrivals(r) >= MOST_WRONG_ARRIVALS]
        reason = outcome.reason or "it could not be done"
        return [self._book.as_ended(r, RequestState.FAILED, reason, facts) for r in served]

    async def _wrong_arrivals(self, request: DeliveryRequest) -> int:
        """How often the robot ended up elsewhere for this request, the open step included."""
        steps = await self._store.steps_of(request.id)
        return 1 + sum(step.state == "elsewhere" for step in steps)


def _unwanted(room: str | None = None) -> StepOutcome:
    return StepOutcome(kind="failed", room=room, reason="nobody wants it any more")


def _served(
    operator: str, arguments: Sequence[str], requests: Sequence[DeliveryRequest], facts: Facts
) -> list[DeliveryRequest]:
    """The requests for which an operator is carried out."""
    match operator:
        case "goto-pickup-loc":
            room = arguments[1]
            return [r for r in requests if r.pickup == room and (r.user, r.item) not in facts.tray]
        case "goto-deliver-loc":
            bound = [r for r in requests if r.destination == arguments[1]]
            return [r for r in bound if (r.user, r.item) in facts.tray] or bound
        case _:
            _, user, item = arguments
            return [r for r in requests if (r.user, r.item) == (user, item)][:1]


def _facts_after(step: Step, outcome: StepOutcome, facts: Facts) -> Facts:
    room = outcome.room
    if outcome.kind != "done" or step.operator in {GOTO_PICKUP, GOTO_DELIVER}:
        return replace(facts, room=room)
    thing = (step.arguments[1], step.arguments[2])
    tray = facts.tray | {thing} if step.operator == ACQUIRE else facts.tray - {thing}
    return Facts(room=room, tray=tray)
