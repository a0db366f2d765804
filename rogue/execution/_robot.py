"""The robot as the agent sees it: modules on the bus that drive, talk and know the map."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol, TypeVar

from pydantic import BaseModel

from navigate.messages import Look as LookAtPlate
from navigate.messages import Rooms, WhereAmI, WhereIsRoom
from rogue.execution._effects import (
    AT_LEISURE,
    AwaitCharge,
    Believe,
    Locate,
    Look,
    TaskOfRobot,
    Urgency,
)
from rogue.outcomes import Outcome
from tca_bus import (
    BusGoneError,
    Goal,
    HandlerFailedError,
    KilledError,
    Module,
    NoHandlerError,
    PeerLostError,
    SendOptions,
    TaskFailedError,
    TaskHandle,
    TcaError,
    TimedOutError,
)
from xavier_sim.messages import BatteryState, ReadBattery

log = logging.getLogger(__name__)

T = TypeVar("T")

MODULE_LOST = "module_lost"
"""What central calls the failure of a task whose handling module died."""

HANDLER_WAIT = 5.0
"""Wall seconds that central holds a task back for its handler; then it is submitted again."""

SHORTEST = 1.0
"""Seconds that a drive is given at least."""

BETWEEN_LOOKS = 30.0
"""Seconds on the module's clock between two looks at a battery that is being charged."""

CAMERA_ABSENCE = 2.0
"""Wall seconds until one who is asked to look and does not answer is taken for blind."""

_PASSING = (BusGoneError, NoHandlerError, PeerLostError, TimedOutError)


STOPPING = 0.02
"""Wall seconds after which a task that is being stopped is looked at again."""


@dataclass(frozen=True, slots=True)
class Endurance:
    """How long the agent waits for a part of the robot to come back, in wall seconds.

    ``lost_times`` is how often one task is begun anew after the module that had it died.
    """

    absence: float = 120.0
    interval: float = 0.5
    lost_times: int = 8


class Robot(Protocol):
    """What a procedure's effects need."""

    async def locate(self, effect: Locate) -> Outcome:
        """Find a room's map location."""

    async def believe(self, effect: Believe) -> Outcome:
        """Ask the navigator where it is."""

    async def look(self, effect: Look) -> Outcome:
        """Read the door plate."""

    async def await_charge(self, effect: AwaitCharge) -> Outcome:
        """Wait until the battery is so full."""

    async def perform(
        self, task_id: str, message: TaskOfRobot, urgency: Urgency = AT_LEISURE
    ) -> Outcome:
        """Carry out a task under an id that names it for ever."""

    async def kill(self, task_id: str, reason: str) -> None:
        """Stop a task, wherever it is, if it was ever begun."""


class BusRobot:
    """`Robot` over a `Module`. What is absent for a moment is waited for."""

    def __init__(self, module: Module, endurance: Endurance | None = None) -> None:
        self._module = module
        self._endurance = endurance or Endurance()

    async def rooms(self, *, patience: float | None = None) -> dict[str, tuple[float, float]]:
        """All rooms of the map with their locations in metres.

        Raises:
            TcaError: the navigator was not to be had within ``patience`` wall seconds.
        """
        found = await self._persist(lambda: self._module.query(Rooms()), patience)
        return {room.room: (room.x / 100.0, room.y / 100.0) for room in found}

    async def locate(self, effect: Locate) -> Outcome:
        """Find a room's map location."""
        return await self._ask(lambda: self._module.query(WhereIsRoom(room=effect.room)))

    async def believe(self, effect: Believe) -> Outcome:
        """Ask the navigator where it is."""
        del effect
        return await self._ask(lambda: self._module.query(WhereAmI()))

    async def look(self, effect: Look) -> Outcome:
        """Read the door plate; a navigator that cannot look is not waited for."""
        if effect.after > 0.0:
            await self._module.clock.sleep(effect.after)
        return await self._ask(lambda: self._module.query(LookAtPlate()), CAMERA_ABSENCE)

    async def await_charge(self, effect: AwaitCharge) -> Outcome:
        """Wait until the battery is so full; fails when it is not being charged."""
        waited = False
        while True:
            seen = await self._ask(lambda: self._module.query(ReadBattery()))
            if seen.failed:
                return seen
            battery = BatteryState.model_validate(seen.value)
            if battery.charge >= effect.charge:
                return seen
            if waited and not battery.charging:
                return Outcome(failure="not_charging", text="the charger gives no current")
            await self._module.clock.sleep(BETWEEN_LOOKS)
            waited = True

    async def perform(
        self, task_id: str, message: TaskOfRobot, urgency: Urgency = AT_LEISURE
    ) -> Outcome:
        """Carry out a task; begin it anew, under the next id, when its module died."""
        outcome = Outcome()
        for identity in self._attempts(task_id):
            outcome = await self._attempt(identity, message, urgency)
            if outcome.failure != MODULE_LOST:
                break
            log.warning("%s lost its module, beginning it anew", identity)
        return outcome

    async def kill(self, task_id: str, reason: str) -> None:
        """Stop a task in the tree whose outcome nobody waits for, with all its attempts.

        Returns when they have ended: the robot stands then.
        """
        for identity in self._attempts(task_id):
            try:
                await self._end(identity, reason)
            except HandlerFailedError:
                return
            except (TcaError, TimeoutError) as error:
                log.warning("task %s could not be stopped: %s", identity, error)
                return

    async def _end(self, task_id: str, reason: str) -> None:
        kill = partial(self._module.kill, task_id, reason=reason)
        async with asyncio.timeout(self._endurance.absence):
            while not (await self._persist(kill)).is_ended:  # noqa: ASYNC110 - asked anew each time
                await asyncio.sleep(STOPPING)

    def _attempts(self, task_id: str) -> list[str]:
        """The ids under which a task is begun, one after the other."""
        again = range(1, self._endurance.lost_times + 1)
        return [task_id, *(f"{task_id}.r{number}" for number in again)]

    async def _attempt(self, task_id: str, message: TaskOfRobot, urgency: Urgency) -> Outcome:
        try:
            handle = await self._persist(lambda: self._submit(task_id, message, urgency))
            result = await handle.result()
        except TaskFailedError as error:
            failure = error.failure
            return Outcome(failure=failure.name, text=failure.text, value=failure.data or {})
        except KilledError as error:
            return Outcome(failure="killed", text=str(error))
        except TcaError as error:
            return Outcome(failure=_name(error), text=str(error))
        return Outcome(value=_plain(result))

    async def _submit(
        self, task_id: str, message: TaskOfRobot, urgency: Urgency
    ) -> TaskHandle[Any]:
        options = SendOptions(id=task_id, wait_for_handler=HANDLER_WAIT, priority=urgency.priority)
        if not isinstance(message, Goal):
            return await self._module.execute(message, **options)
        if urgency.deadline is not None:
            # Should the agent be dead by then, the drive ends all the same.
            options["within"] = max(urgency.deadline - self._module.clock.now(), SHORTEST)
        return await self._module.expand(message, **options)

    async def _ask(
        self, query: Callable[[], Awaitable[BaseModel]], patience: float | None = None
    ) -> Outcome:
        try:
            return Outcome(value=_plain(await self._persist(query, patience)))
        except HandlerFailedError as error:
            return Outcome(failure=error.failure.name, text=error.failure.text)
        except TcaError as error:
            return Outcome(failure=_name(error), text=str(error))

    async def _persist(self, call: Callable[[], Awaitable[T]], patience: float | None = None) -> T:
        """Call again while the other side is away, for at most ``patience`` wall seconds."""
        limit = self._endurance.absence if patience is None else patience
        end = time.monotonic() + limit
        while True:
            try:
                return await call()
            except _PASSING as error:
                if time.monotonic() >= end:
                    raise
                log.info("waiting for the other side: %s", error)
            await asyncio.sleep(self._endurance.interval)


def _plain(result: BaseModel) -> dict[str, Any]:
    return result.model_dump(mode="json")


def _name(error: TcaError) -> str:
    """``NoHandlerError`` is called ``no_handler``, as a failure is."""
    words = type(error).__name__.removesuffix("Error")
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in words).lstrip("_")
