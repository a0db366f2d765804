"""Modules of one process that have their Zenoh session in common."""

from __future__ import annotations

import asyncio
import threading

import pytest
from mortal_router import MortalRouter

from tca_bus import (
    Broadcast,
    BusGoneError,
    BusOptions,
    ConfigError,
    Inform,
    Module,
    PeerLostError,
    Query,
    Router,
)
from tca_bus.testing import FREE_PORT, eventually

pytestmark = pytest.mark.bus


class Ask(Query[int]):
    number: int


class Tell(Inform):
    number: int


class Shout(Broadcast):
    number: int


@pytest.fixture
async def options():
    async with Router(FREE_PORT) as router:
        yield BusOptions(connect=router.endpoint, realm="shared", session="shared")


def server(options, told=None, name="server"):
    module = Module(name, options=options)

    @module.handler(Ask)
    async def ask(message, context):
        return message.number + 1

    @module.handler(Tell)
    async def tell(message, context):
        told.append((name, message.number))

    @module.handler(Shout)
    async def shout(message, context):
        told.append((name, message.number))

    return module


def names(module):
    return [one.name for one in module.modules()]


async def test_modules_of_one_session_see_and_ask_and_tell_each_other(options):
    told = []
    async with server(options, told), Module("asker", options=options) as asker:
        assert names(asker) == ["asker", "server"]
        assert await asker.query(Ask(number=1)) == 2
        await asker.inform(Tell(number=3))
        await asker.broadcast(Shout(number=4))
        await eventually(lambda: told == [("server", 3), ("server", 4)])


async def test_a_module_has_no_connection_or_thread_of_messages_to_itself(options):
    async with Module("first", options=options) as first:
        before = threading.active_count()
        async with Module("second", options=options) as second:
            assert second.core.session.zenoh is first.core.session.zenoh
            assert threading.active_count() <= before + 2


async def test_modules_of_a_session_and_others_see_each_other(options):
    alone = options.model_copy(update={"session": "own"})
    told = []
    async with (
        server(options, told, "inside"),
        server(options, told, "beside"),
        server(alone, told, "outside") as outside,
        Module("asker", options=options) as asker,
    ):
        assert outside.core.session.zenoh is not asker.core.session.zenoh
        await eventually(lambda: len(names(outside)) == len(names(asker)) == 4)
        await asker.broadcast(Shout(number=1))
        await eventually(lambda: sorted(told) == [(n, 1) for n in ("beside", "inside", "outside")])
        assert await asker.query(Ask(number=1), to="outside") == 2
        assert await outside.query(Ask(number=1), to="inside") == 2


async def test_when_one_leaves_it_is_gone_and_the_others_go_on(options):
    async with server(options) as first, Module("asker", options=options) as asker:
        async with server(options, name="passing"):
            await eventually(lambda: "passing" in names(asker))
            assert await asker.query(Ask(number=1), to="passing") == 2
        await eventually(lambda: names(asker) == names(first) == ["asker", "server"])
        assert await asker.query(Ask(number=1)) == 2


async def test_a_question_under_way_to_one_that_leaves_fails_at_once(options):
    leaving = Module("leaving", options=options)
    asked = asyncio.Event()

    @leaving.handler(Ask)
    async def ask(message, context):
        asked.set()
        await asyncio.get_running_loop().create_future()

    async with Module("asker", options=options) as asker:
        async with leaving:
            await asker.wait_for(Ask, timeout=10.0)
            question = asyncio.create_task(asker.query(Ask(number=1), timeout=30.0))
            await asked.wait()
        with pytest.raises(PeerLostError):
            await asyncio.wait_for(question, 10.0)


async def test_the_session_is_closed_with_the_last_and_opened_for_the_next(options):
    async with Module("first", options=options) as first:
        once = first.core.session.zenoh
    assert once.is_closed()
    async with Module("second", options=options) as second:
        assert names(second) == ["second"]


async def test_all_open_at_once(options):
    modules = [Module(f"m{number:02}", options=options) for number in range(20)]
    await asyncio.gather(*(module.__aenter__() for module in modules))
    try:
        await eventually(lambda: all(len(names(module)) == 20 for module in modules))
    finally:
        for module in modules:
            await module.__aexit__(None, None, None)


async def test_all_are_told_of_the_loss_of_the_router_and_of_its_return():
    async with (
        MortalRouter(session="shared") as router,
        server(router.options) as first,
        Module("asker", options=router.options) as asker,
    ):
        await router.die()
        await eventually(lambda: not first.is_connected and not asker.is_connected)
        late = router.options.model_copy(update={"connect_timeout": 0.3})
        with pytest.raises(BusGoneError):
            async with Module("late", options=late):
                pass
        await router.rise()
        await asyncio.wait_for(asyncio.gather(first.connected(), asker.connected()), 10.0)
        assert await asker.query(Ask(number=1), timeout=10.0) == 2
        assert names(asker) == ["asker", "server"]
        assert first.outages == asker.outages == 1


@pytest.mark.parametrize(
    "more", [{"links": "direct"}, {"user": "me", "password": "secret"}, {"keys": "keys"}]
)
def test_a_shared_session_is_refused_where_each_module_needs_its_own(more):
    with pytest.raises(ConfigError, match="a session of its own"):
        BusOptions(session="shared", **more)
