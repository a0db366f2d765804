"""Listens on the bus to what others say of the robot, and has it recorded."""

from __future__ import annotations

import asyncio
import logging
import os
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import TypeVar

from tca_bus import BusOptions, Module, RefusedError, Subscription, TaskStatus
from xavier_sim.recording._heard import Belief, Progress
from xavier_sim.recording._recorder import Recorder

log = logging.getLogger(__name__)

T = TypeVar("T")


@asynccontextmanager
async def listening(recorder: Recorder, options: BusOptions) -> AsyncIterator[None]:
    """Record beliefs, drives and task states until the block is left.

    What the policy of the router keeps from the robot is left out, with a warning.

    Args:
        recorder: that is open.
        options: how to join the bus.
    """
    wall = options.model_copy(update={"clock": "wall"})
    module = Module(f"xavier-{os.getpid()}", options=wall)
    async with module, asyncio.TaskGroup() as group:
        streams = (
            group.create_task(_beliefs(module, recorder), name="recorder hears beliefs"),
            group.create_task(_drives(module, recorder), name="recorder hears drives"),
            group.create_task(_tasks(module, recorder), name="recorder hears tasks"),
        )
        try:
            yield
        finally:
            for stream in streams:
                stream.cancel()


async def _beliefs(module: Module, recorder: Recorder) -> None:
    await _follow(lambda: module.subscribe(Belief), recorder, recorder.believe)


async def _drives(module: Module, recorder: Recorder) -> None:
    await _follow(lambda: module.subscribe(Progress), recorder, recorder.advance)


async def _tasks(module: Module, recorder: Recorder) -> None:
    def hear(status: TaskStatus) -> None:
        recorder.hear(status)

    await _follow(module.watch_statuses, recorder, hear)


async def _follow(
    subscribe: Callable[[], Subscription[T]], recorder: Recorder, take: Callable[[T], None]
) -> None:
    missed = 0
    try:
        async with subscribe() as messages:
            async for message in messages:
                take(message)
                recorder.miss(messages.dropped - missed)
                missed = messages.dropped
    except RefusedError as error:
        log.warning("the recording lacks something: %s", error)
