"""What happens when the router or a module dies under way."""

from __future__ import annotations

import asyncio
import math

import pytest
from bus_process import victim
from bus_victim import Sleep
from mortal_router import MortalRouter

from tca_bus import (
    Broadcast,
    BusGoneError,
    Inform,
    Module,
    NoHandlerError,
    PeerLostError,
    Query,
)
from tca_bus._protocol import Describe
from tca_bus.testing import bus, eventually

pytestmark = pytest.mark.bus


class Work(Query[int]):
    number: int


class Tell(Inform):
    number: int


class Shout(Broadcast):
    number: int


def worker(options, go, numbers):
    module = Module("worker", options=options)

    @module.handler(Work)
    async def work(message, context):
        numbers.append(message.number)
        await go.wait()
        return message.number

    return module


async def test_a_query_to_a_module_that_is_killed_ends_as_peer_lost():
    async with bus() as options, Module("asker", options=options) as asker, victim(options) as it:
        await asker.wait_for(Sleep, timeout=20.0)
        query = asyncio.create_task(asker.query(Sleep(), timeout=20.0))
        # Answered after the query before it has begun: both go the same way.
        await asker.query(Describe(), to="victim")
        it.kill()
        with pytest.raises(PeerLostError, match="'victim'"):
            await query
        with pytest.raises(NoHandlerError):
            await asker.query(Sleep())


async def test_a_killed_module_is_reported_once():
    async with (
        bus() as options,
        Module("asker", options=options) as asker,
        asker.watch_modules() as changes,
        victim(options) as it,
    ):
        await asker.wait_for(Sleep, timeout=20.0)
        it.kill()
        seen = [await changes.get() for _ in range(3)]
        assert [(change.module.name, change.appeared) for change in seen] == [
            ("asker", True),
            ("victim", True),
            ("victim", False),
        ]


async def test_a_waiting_query_survives_the_router_and_is_handled_once():
    go = asyncio.Event()
    numbers: list[int] = []
    async with (
        MortalRouter() as router,
        worker(router.options, go, numbers),
        Module("asker", options=router.options) as asker,
        asker.watch_modules() as changes,
    ):
        await asker.wait_for(Work, timeout=10.0)
        query = asyncio.create_task(asker.query(Work(number=1), timeout=30.0))
        await eventually(lambda: numbers == [1])
        await router.die()
        await eventually(lambda: not asker.is_connected)
        later = asyncio.create_task(asker.query(Work(number=2), timeout=30.0))
        await router.rise()
        await asker.connected()
        go.set()
        assert await query == 1
        assert await later == 2
        assert numbers == [1, 2]
        await eventually(lambda: asker.core.presence.table.next_expiry() == math.inf)
        seen = [await changes.get() for _ in range(2)]
        assert {change.module.name for change in seen} == {"asker", "worker"}
        assert changes.waiting == 0


async def test_an_answer_that_was_lost_with_the_router_is_given_again():
    go = asyncio.Event()
    numbers: list[int] = []
    async with (
        MortalRouter() as router,
        worker(router.options, go, numbers),
        Module("asker", options=router.options) as asker,
    ):
        await asker.wait_for(Work, timeout=10.0)
        query = asyncio.create_task(asker.query(Work(number=1), timeout=30.0))
        await eventually(lambda: numbers == [1])
        await router.die()
        await eventually(lambda: not asker.is_connected)
        go.set()
        await router.rise()
        assert await query == 1
        assert numbers == [1]


async def test_while_the_router_is_away_asking_says_so_and_broadcasting_counts():
    async with MortalRouter() as router:
        impatient = router.options.model_copy(update={"connect_timeout": 0.2})
        async with Module("asker", options=impatient) as asker:
            await router.die()
            await eventually(lambda: not asker.is_connected)
            with pytest.raises(BusGoneError):
                await asker.query(Work(number=1), timeout=0.2)
            with pytest.raises(BusGoneError):
                await asker.inform(Tell(number=1))
            await asker.broadcast(Shout(number=1))


async def test_subscriptions_go_on_after_the_router_is_back():
    async with (
        MortalRouter() as router,
        Module("robot", options=router.options) as robot,
        Module("hearer", options=router.options) as hearer,
        hearer.subscribe(Shout) as shouts,
    ):
        await router.die()
        await eventually(lambda: not robot.is_connected and not hearer.is_connected)
        await router.rise()
        await robot.connected()
        await hearer.connected()

        async def heard() -> bool:
            await robot.broadcast(Shout(number=7))
            return shouts.waiting > 0

        await eventually(heard)
        assert (await shouts.get()).number == 7
