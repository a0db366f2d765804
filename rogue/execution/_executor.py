"""Carrying out operators: which procedure, which requests it serves, what it changes."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Awaitable, Callable, Iterable, Sequence
from dataclasses import dataclass

from rogue import trace
from rogue.decisions import moved, put_off
from rogue.execution._effects import Procedure, Urgency
from rogue.execution._judgement import Case, Verdict, judge
from rogue.execution._operators import (
    ACQUIRE,
    DRIVES,
    GOTO_PICKUP,
    HAND_OVERS,
    RECHARGE,
    next_room,
    room_of,
    served_by,
    thing,
    thing_of,
)
from rogue.execution._patience import Patience
from rogue.execution._procedures import acquire, deliver, go_to, recharge
from rogue.execution._steps import StepRunner
from rogue.execution._verification import Verification
from rogue.execution._world import KnownWorld
from rogue.memory import Step, Store
from rogue.messages import DeliveryRequest, RequestState
from rogue.outcomes import StepOutcome, Thing, Trouble
from rogue.requests import Directory, RequestBook
from tca_bus import Module

log = logging.getLogger(__name__)

ARRIVED = frozenset({Trouble.BLOCKED, Trouble.HINDERED, Trouble.UNSURE})
"""Troubles at a room that are over when the robot has got there."""

MET = ARRIVED | {Trouble.NOBODY}
"""Troubles at a room that are over when somebody there has handed something over."""

OF_ITS_OWN = 100
"""Priority of what the robot needs itself, above that of any errand."""

NOBODY_WANTS_IT = "nobody wants it any more"


@dataclass(slots=True)
class _Current:
    """The step that is being carried out, and which of its things were on the tray then."""

    step: Step
    task: asyncio.Task[StepOutcome]
    carried: frozenset[Thing]


class Executor:
    """Runs one operator at a time, durably, and keeps what it changed.

    ``after_step`` is awaited when a step has ended, before anything is planned on it.
    """

    def __init__(
        self,
        *,
        module: Module,
        store: Store,
        book: RequestBook,
        world: KnownWorld,
        directory: Directory,
        runner: StepRunner,
        patience: Patience,
        arrival: Verification,
    ) -> None:
        self._module = module
        self._store = store
        self._book = book
        self._directory = directory
        self._runner = runner
        self._patience = patience
        self._arrival = arrival
        self._current: _Current | None = None
        self._still = contextlib.ExitStack()
        self.world = world
        self.after_step: Callable[[], Awaitable[None]] = _nothing

    async def execute(
        self, operator: str, arguments: Sequence[str], request_ids: Iterable[str]
    ) -> StepOutcome:
        """Carry out an operator for those of the requests that it serves.

        An operator that serves nobody any more fails at once, and nothing moves.
        """
        if operator in DRIVES:
            await self._recharge_if_low()
        tray = self.world.facts.tray
        served = served_by(operator, arguments, self._found(request_ids), tray)
        if not served:
            return _unwanted(self.world.facts.room)
        begun = [self._book.as_begun(request) for request in served]
        step = await self._store.begin_step(operator, arguments, begun, self._module.clock.now())
        if step is None:
            return _unwanted(self.world.facts.room)
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

    def reconsider(self) -> None:
        """Break off a drive that is of no use any more."""
        current = self._current
        if current is not None and not self._is_of_use(current.step, current.carried):
            # In lockstep the world goes on when the robot stands.
            self._still.enter_context(self._module.clock.hold())
            current.task.cancel()

    def is_handing_over(self, thing: Thing) -> bool:
        """Whether somebody is putting an item on the tray or taking it from there just now."""
        step = self._current.step if self._current is not None else None
        return step is not None and step.operator in HAND_OVERS and thing_of(step) == thing

    async def _recharge_if_low(self) -> None:
        """Serve the robot's own need before it drives on; whatever comes of it, it drives then."""
        battery, now = self.world.battery, self._module.clock.now()
        if battery is None or not battery.low or battery.charger is None:
            return
        tried = await self._store.last_ended(RECHARGE)
        if tried is not None and now < tried + self._patience.later:
            return
        where = (str(battery.charger.x), str(battery.charger.y))
        step = await self._store.begin_step(RECHARGE, where, [], now)
        if step is not None:
            await self._run(step)

    async def _run(self, step: Step) -> StepOutcome:
        outcome = await self._outcome(step)
        verdict = await self._verdict(step, outcome)
        await self._runner.tell_after(step, _lines(verdict))
        facts = self.world.facts.changed(
            room=outcome.room, placed=outcome.placed, gone=outcome.gone
        )
        done, failed = RequestState.COMPLETED, RequestState.FAILED
        changed = [self._book.as_ended(r, done, None, facts) for r in verdict.done]
        changed += [self._book.as_given_up(r, failed, why, facts) for r, why in verdict.hopeless]
        changed += [self._book.as_closed(r, facts) for r in verdict.closed]
        changed += verdict.moved
        changed += [self._book.as_put_off(r) for r in self._found(h.request for h in verdict.holds)]
        now, holds = self._module.clock.now(), verdict.holds
        self._store.record([*put_off(holds, now), *moved(verdict.moved, now)])
        ended = await self._store.end_step(step, outcome, now, changed=changed, holds=holds)
        self.world.after_step(outcome, holds)
        for request in ended:
            await self._book.took_effect(request)
        if outcome.kind == "done" and step.operator != RECHARGE:
            cured = ARRIVED if step.operator in DRIVES else MET
            await self.world.take_up(room_of(step), cured)
        await self.after_step()
        return outcome

    async def _outcome(self, step: Step) -> StepOutcome:
        carried = frozenset(map(thing, self._found(step.requests))) & self.world.facts.tray
        if not self._is_of_use(step, carried):
            await self._runner.abandon(step, self._procedure(step), NOBODY_WANTS_IT)
            return _unwanted()
        run = self._runner.run(step, self._procedure(step), self._urgency(step))
        task = asyncio.create_task(run, name=f"step-{step.number}")
        self._current = _Current(step, task, carried)
        try:
            return await task
        except asyncio.CancelledError:
            own = asyncio.current_task()
            if own is not None and own.cancelling():
                raise
            await self._runner.abandon(step, self._procedure(step), NOBODY_WANTS_IT)
            return _unwanted()
        finally:
            self._current = None
            self._still.close()

    def _is_of_use(self, step: Step, carried: frozenset[Thing]) -> bool:
        """Whether somebody waits for a step; who has begun to hand something over goes on."""
        if step.operator not in DRIVES:
            return True
        tray, room = self.world.facts.tray, room_of(step)
        wanted = [r for r in self._found(step.requests) if self.world.waits(r) is None]
        if step.operator == GOTO_PICKUP:
            return any(r.pickup == room and thing(r) not in tray for r in wanted)
        return any(r.destination == room and (thing(r) in tray or not carried) for r in wanted)

    def _found(self, request_ids: Iterable[str]) -> list[DeliveryRequest]:
        found = (self._book.find(request_id) for request_id in request_ids)
        return [request for request in found if request is not None]

    def _urgency(self, step: Step) -> Urgency:
        """The priority of the most important request, and the latest of the deadlines."""
        if step.operator == RECHARGE:
            return Urgency(priority=OF_ITS_OWN)
        served = self._found(step.requests)
        closing = any(request.closing is not None for request in served)
        deadlines = [request.deadline for request in served]
        return Urgency(
            priority=max((request.rank for request in served), default=0),
            deadline=None if closing else max(deadlines, default=None),
        )

    def _procedure(self, step: Step) -> Procedure:
        if step.operator in DRIVES:
            start = self.world.facts.room
            return go_to(room_of(step), self._patience, self._arrival, start=start)
        if step.operator == RECHARGE:
            x, y = map(float, step.arguments)
            return recharge(x, y, self._patience.charge)
        user, item = thing_of(step)
        phrase = self._directory.phrase(user, item)
        hand_over = acquire if step.operator == ACQUIRE else deliver
        return hand_over(room_of(step), (user, item), phrase, self._patience, self._arrival)

    async def _verdict(self, step: Step, outcome: StepOutcome) -> Verdict:
        served, room, tray = self._found(step.requests), room_of(step), self.world.facts.tray
        case = Case(
            step=step,
            outcome=outcome,
            served=served,
            others=[
                request
                for request in self._book.open_requests()
                if request not in served and next_room(request, tray) == room
            ],
            past={request.id: await self._store.past_of(request.id) for request in served},
            rooms={r.id: self._directory.other_rooms(r.user, room) for r in served},
            facts=self.world.facts,
            now=self._module.clock.now(),
        )
        return judge(case, self._patience)


def _unwanted(room: str | None = None) -> StepOutcome:
    return StepOutcome(kind="failed", room=room, reason=NOBODY_WANTS_IT, trouble=Trouble.UNWANTED)


def _lines(verdict: Verdict) -> list[str]:
    """What the conversation says of what was decided."""
    said = [f"{hold.request} is put off: {hold.outlook}." for hold in verdict.holds]
    said += [
        f"{request.id} goes on: from {request.pickup} to {request.destination}."
        for request in verdict.moved
    ]
    return [*map(trace.remark, said), ""] if said else []


async def _nothing() -> None:
    """What is done after a step before anybody cares."""
