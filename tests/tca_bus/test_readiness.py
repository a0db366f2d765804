"""Starting together (tca.md 3.1): provides, requires, waiting until ready, holding back."""

from __future__ import annotations

import asyncio
import logging

import pytest

from tca_bus import (
    BusyError,
    Command,
    ConfigError,
    Inform,
    Module,
    NoHandlerError,
    Query,
    TimedOutError,
)
from tca_bus._keys import Keys, parse_presence
from tca_bus._presence import PresenceTable, PresentModule, Stage
from tca_bus.testing import bus, central, eventually

KEYS = Keys("realm")


class Ask(Query[int]):
    pass


class Tell(Inform):
    number: int


class Do(Command[int]):
    pass


def present(name="a", incarnation="01", **more):
    return PresentModule(name, incarnation, "host", 7, ("ask",), **more)


@pytest.mark.parametrize(
    "module",
    [
        present(),
        present(number=3),
        present(resources=("map", "dock"), requires=("odometry",), stage=Stage.HELD, number=2),
        present(requires=("x-1",), stage=Stage.READY),
    ],
)
def test_a_token_says_what_a_module_offers_and_requires(module):
    assert parse_presence(KEYS.presence(module)) == module


def test_a_token_without_more_is_understood():
    assert parse_presence("realm/presence/a/01/host/7/ask") == present()


@pytest.mark.parametrize("more", ["x", "1,late", "", "-1x,+a"])
def test_a_token_with_something_else_is_none(more):
    with pytest.raises(ValueError, match=r"int|Stage"):
        parse_presence(f"realm/presence/a/01/host/7/ask/{more}")


def test_a_token_that_was_replaced_does_not_come_back():
    table = PresenceTable()
    table.put(present(number=2, resources=("map",)), now=0.0)
    assert table.put(present(number=1), now=0.0) == []
    table.delete(present(number=1), now=0.0)
    assert table.resources() == {"a", "map"}
    assert table.state_of("01") is True


def test_what_a_suspect_offers_is_not_there():
    table = PresenceTable()
    table.put(present(resources=("map",)), now=0.0)
    table.delete(present(resources=("map",)), now=0.0)
    assert table.resources() == set()


def test_a_resource_has_a_name_that_fits_a_key():
    with pytest.raises(ConfigError, match="provides is 'a,b'"):
        Module("x", provides=["a,b"])
    with pytest.raises(ConfigError, match="requires is 'map', expected a list"):
        Module("x", requires="map")


def served(name, options, **more):
    module = Module(name, options=options, **more)
    told: list[int] = []

    async def ask(message, context):
        return 1

    async def tell(message, context):
        told.append(message.number)

    for kind in (Ask, Do):
        module.serve(kind, ask)
    module.serve(Tell, tell)
    return module, told


@pytest.mark.bus
async def test_nothing_is_delivered_before_a_module_is_ready():
    async with bus() as options, central(options), Module("me", options=options) as me:
        module, told = served("held", options, hold=True)
        async with module:
            await eventually(lambda: "held" in me.available())
            with pytest.raises(NoHandlerError):
                await me.query(Ask())
            with pytest.raises(NoHandlerError):
                await me.inform(Tell(number=1))
            with pytest.raises(BusyError, match="'held' is not ready yet"):
                await me.query(Ask(), to="held")
            task = await me.execute(Do(), wait_for_handler=30.0)
            assert task.status.handler is None
            module.ready()
            assert await task.result(timeout=10.0) == 1
            await me.wait_for(Ask, Tell, timeout=10.0)
            await me.inform(Tell(number=2))
            assert await me.query(Ask()) == 1
            await eventually(lambda: told == [2])


@pytest.mark.bus
async def test_those_that_require_each_other_become_ready_together():
    async with bus() as options:
        maps, _ = served("maps", options, provides=["map"], requires=["odometry"], hold=True)
        base, _ = served("base", options, provides=["odometry"], requires=["map"], hold=True)
        async with maps:
            waiting = asyncio.create_task(maps.wait_until_ready(timeout=30.0, modules=2))
            async with base:
                names = {"maps", "base", "map", "odometry"}
                await eventually(lambda: names <= set(base.available()))
                assert not waiting.done()
                await base.wait_until_ready(timeout=30.0, modules=2)
                await waiting
                assert await base.query(Ask(), to="maps") == 1


@pytest.mark.bus
async def test_a_wait_that_is_too_long_names_what_is_missing_and_may_be_repeated():
    async with bus() as options:
        module, _ = served("x", options, requires=["map"], hold=True)
        async with module, Module("me", options=options) as me:
            expected = "waits for resource 'map', 1 of 2 modules to be ready"
            with pytest.raises(TimedOutError, match=expected):
                await module.wait_until_ready(timeout=0.1, modules=2)
            with pytest.raises(BusyError):
                await me.query(Ask(), to="x")
            async with Module("maps", options=options, provides=["map"]) as maps:
                maps.ready()
                await module.wait_until_ready(timeout=10.0, modules=2)
                assert await me.query(Ask(), to="x") == 1


@pytest.mark.bus
async def test_two_modules_of_one_name_are_both_seen_and_both_warn_once(caplog):
    caplog.set_level(logging.WARNING, logger="tca_bus")
    async with (
        bus() as options,
        Module("twin", options=options) as first,
        Module("me", options=options) as me,
        Module("twin", options=options) as second,
    ):
        await eventually(lambda: len(warnings(caplog)) == 2)
        second.serve(Ask, answer)
        first.serve(Ask, answer)
        both = {first.incarnation, second.incarnation}
        for module in (me, first, second):
            await eventually(lambda module=module: both == asked(module))
        assert len(warnings(caplog)) == 2


def warnings(caplog):
    return [r for r in caplog.records if "another module is named 'twin'" in r.message]


def asked(module):
    """Those who handle the question, as a module sees it."""
    return {other.incarnation for other in module.modules() if "ask" in other.provides}


async def answer(message, context):
    return 1
