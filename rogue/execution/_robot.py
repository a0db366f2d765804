"""The robot as the agent sees it: modules on the bus that drive, talk and know the map."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from pydantic import BaseModel

from navigate.messages import Rooms, WhereAmI, WhereIsRoom
from rogue.execution._effects import Believe, Locate, Look, Pause, TaskOfRobot
from rogue.outcomes import Outcome
from tca_bus import (
    BusGoneError,
    Goal,
    HandlerFailedError,
    KilledError,
    Module,
    NoHandlerError,
    PeerLostError,
    TaskFailedError,
    TaskHandle,
    TcaError,
    TimedOutError,
)
from xavier_sim.messages import ReadPlate

log = logging.getLogger(__name__)

T = TypeVar("T")

MODULE_LOST = "module_lost"
"""What central calls the failure of a task whose handling module died."""

HANDLER_WAIT = 5.0
"""Wall seconds that central holds a task back for its handler; then it is submitted again."""

CAMERA_ABSENCE = 2.0
"""Wall seconds until a camera that does not answer is taken for none."""

_PASSING = (BusGoneError, NoHandlerError, PeerLostError, TimedOutError)


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

    async def pause(self, effect: Pause) -> Outcome:
        """Wait on the world's clock."""

    async def perform(self, task_id: str, message: TaskOfRobot) -> Outcome:
        """Carry out a task under an id that names it for ever."""


class BusRobot:
    """`Robot` over a `Module`. What is absent for a moment is waited for."""

    def __init__(self, module: Module, endurance: Endurance | None = None) -> None:
        self._module = module
        self._endurance = endurance or Endurance()
        self._running: str | None = None

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
        """Read the door plate; a robot that has no camera is not waited for."""
        del effect
        return await self._ask(lambda: self._module.query(ReadPlate()), CAMERA_ABSENCE)

    async def pause(self, effect: Pause) -> Outcome:
        """Wait on the world's clock."""
        await self._module.clock.sleep(effect.seconds)
        return Outcome()

    async def perform(self, task_id: str, message: TaskOfRobot) -> Outcome:
        """Carry out a task; begin it anew, under the next id, when its module died."""
        outcome = Outcome()
        for attempt in range(self._endurance.lost_times + 1):
            identity = f"{task_id}.r{attempt}" if attempt else task_id
            outcome = await self._attempt(identity, message)
            if outcome.failure != MODULE_LOST:
                break
            log.warning("%s lost its module, beginning it anew", identity)
        return outcome

    @property
    def running(self) -> str | None:
        """Id of the task that is being carried out."""
        return self._running

    async def kill(self, task_id: str, reason: str) -> None:
        """Stop a task whose outcome nobody waits for any more."""
        try:
            await self._persist(lambda: self._module.kill(task_id, reason=reason))
        except TcaError as error:
            log.warning("task %s could not be stopped: %s", task_id, error)

    async def _attempt(self, task_id: str, message: TaskOfRobot) -> Outcome:
        self._running = task_id
        try:
            handle = await self._persist(lambda: self._submit(task_id, message))
            result = await handle.result()
        except TaskFailedError as error:
            return Outcome(failure=error.failure.name, text=error.failure.text)
        except KilledError as error:
            return Outcome(failure="killed", text=str(error))
        except TcaError as error:
            return Outcome(failure=_name(error), text=str(error))
        finally:
            self._running = None
        return Outcome(value=_plain(result))

    async def _submit(self, task_id: str, message: TaskOfRobot) -> TaskHandle[Any]:
        if isinstance(message, Goal):
            return await self._module.expand(message, id=task_id, wait_for_handler=HANDLER_WAIT)
        return await self._module.execute(message, id=task_id, wait_for_handler=HANDLER_WAIT)

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
