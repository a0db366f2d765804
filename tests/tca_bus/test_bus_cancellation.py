"""Handlers that end as cancelled although nobody cancelled them."""

from __future__ import annotations

import asyncio

import pytest

from tca_bus import Broadcast, Command, Module, Query, RefusedError, TaskFailedError
from tca_bus.testing import bus, central, eventually

pytestmark = pytest.mark.bus


class Look(Query[int]):
    number: int


class Tell(Broadcast):
    number: int


class Toil(Command[int]):
    number: int


class Worker:
    """Handles zero by waiting for something that is cancelled; notes all it was asked."""

    def __init__(self, options):
        self.module = Module("worker", options=options)
        self.seen: list[int] = []
        for kind in (Look, Tell, Toil):
            self.module.serve(kind, self.handle)

    async def handle(self, message, context):
        self.seen.append(message.number)
        if message.number == 0:
            lost = asyncio.get_running_loop().create_future()
            lost.cancel()
            await lost
        return message.number


async def test_a_query_whose_handler_ends_as_cancelled_is_handled_once_and_refused():
    async with bus() as options, Module("asker", options=options) as asker:
        worker = Worker(options)
        async with worker.module:
            await asker.wait_for(Look, timeout=10.0)
            with pytest.raises(RefusedError, match="its handler was cancelled"):
                await asker.query(Look(number=0))
            assert worker.seen == [0]


async def test_after_a_handler_that_ends_as_cancelled_the_next_message_is_handled():
    async with bus() as options, Module("teller", options=options) as teller:
        worker = Worker(options)
        async with worker.module:
            await teller.wait_for(Look, timeout=10.0)
            await teller.broadcast(Tell(number=0))
            await teller.broadcast(Tell(number=1))
            await eventually(lambda: worker.seen == [0, 1])


async def test_a_task_whose_handler_ends_as_cancelled_has_failed():
    async with bus() as options, central(options), Module("boss", options=options) as boss:
        worker = Worker(options)
        async with worker.module:
            await boss.wait_for(Toil, "tca.submit", timeout=10.0)
            with pytest.raises(TaskFailedError) as caught:
                await (await boss.execute(Toil(number=0))).result(timeout=10.0)
            assert caught.value.failure.name == "refused"
