"""Direct links: modules that reach each other without the router, and those that need it."""

from __future__ import annotations

import asyncio
import math

import pytest
import zenoh
from bus_process import victim
from bus_victim import Sleep
from mortal_router import MortalRouter

from tca_bus import (
    Broadcast,
    BusGoneError,
    Inform,
    Module,
    PeerLostError,
    Query,
)
from tca_bus.cli._flags import BusFlags, bus_options
from tca_bus.testing import eventually


class Ask(Query[int]):
    number: int


class Tell(Inform):
    number: int


class Shout(Broadcast):
    number: int


@pytest.fixture
async def router():
    async with MortalRouter(links="direct") as router:
        yield router


def server(options, told=None, name="server"):
    module = Module(name, options=options)

    @module.handler(Ask)
    async def ask(message, context):
        return message.number + 1

    @module.handler(Tell)
    async def tell(message, context):
        told.append(message.number)

    return module


def peers(module):
    transports = module._parts.core.session.zenoh.info.transports()
    return [one for one in transports if one.whatami == zenoh.WhatAmI.PEER]


async def linked(module):
    await module.wait_for(Ask, timeout=10.0)
    await eventually(lambda: peers(module))


@pytest.mark.bus
async def test_linked_modules_go_on_while_the_router_is_away(router):
    told: list[int] = []
    options = router.options
    async with server(options, told) as one, Module("asker", options=options) as asker:
        await linked(asker)
        assert await asker.query(Ask(number=1)) == 2
        await router.die()
        await eventually(lambda: not asker.is_connected and not one.is_connected)
        assert await asker.query(Ask(number=2)) == 3
        await asker.inform(Tell(number=4))
        await eventually(lambda: told == [4])
        async with asker.subscribe(Shout) as shouts:
            await one.broadcast(Shout(number=5))
            assert (await shouts.get()).number == 5
        assert [module.name for module in asker.modules()] == ["asker", "server"]


@pytest.mark.bus
async def test_linked_modules_meet_newcomers_when_the_router_is_back(router):
    options = router.options
    async with server(options, []), Module("asker", options=options) as asker:
        await linked(asker)
        await router.die()
        await eventually(lambda: not asker.is_connected)
        await router.rise()
        await asker.connected()
        async with server(options, [], name="newcomer"):
            await eventually(lambda: len(asker.modules()) == 3)
            assert await asker.query(Ask(number=1), to="newcomer") == 2
            assert await asker.query(Ask(number=2), to="server") == 3


@pytest.mark.bus
async def test_a_module_without_links_is_reached_through_the_router(router):
    through = router.options.model_copy(update={"links": "router"})
    async with server(through, []) as far, Module("asker", options=router.options) as asker:
        await asker.wait_for(Ask, timeout=10.0)
        assert await asker.query(Ask(number=1)) == 2
        assert not peers(asker)
        async with far.subscribe(Shout) as shouts:
            await asker.broadcast(Shout(number=5))
            assert (await shouts.get()).number == 5


@pytest.mark.bus
async def test_a_module_without_links_is_not_lost_while_the_router_is_away(router):
    through = router.options.model_copy(update={"links": "router"})
    async with (
        server(through, []),
        Module("asker", options=router.options) as asker,
        asker.watch_modules() as changes,
    ):
        await asker.wait_for(Ask, timeout=10.0)
        await router.die()
        await eventually(lambda: not asker.is_connected)
        with pytest.raises(BusGoneError):
            await asker.query(Ask(number=1), timeout=0.2)
        later = asyncio.create_task(asker.query(Ask(number=2), timeout=30.0))
        await router.rise()
        assert await later == 3
        await eventually(lambda: asker.core.presence.table.next_expiry() == math.inf)
        assert {(await changes.get()).module.name for _ in range(2)} == {"asker", "server"}
        assert changes.waiting == 0


@pytest.mark.bus
@pytest.mark.process
async def test_a_linked_module_that_is_killed_is_lost(router):
    async with Module("asker", options=router.options) as asker, victim(router.options) as it:
        await asker.wait_for(Sleep, timeout=20.0)
        await eventually(lambda: peers(asker))
        query = asyncio.create_task(asker.query(Sleep(), timeout=20.0))
        await eventually(lambda: len(asker._parts.caller._asking._pending) == 1)
        it.kill()
        with pytest.raises(PeerLostError, match="'victim'"):
            await query


def test_the_flag_chooses_the_links():
    assert bus_options(BusFlags(links="direct")).is_direct
    assert not bus_options(BusFlags()).is_direct
