"""Informs and broadcasts over a real router: who hears them, and in which order."""

from __future__ import annotations

import asyncio

import pytest

from tca_bus import Broadcast, ConfigError, Inform, Module, NoHandlerError, Query
from tca_bus._protocol import Describe
from tca_bus.arrays import Float32Array
from tca_bus.testing import bus, eventually

pytestmark = pytest.mark.bus


class Note(Inform):
    number: int


class Said(Broadcast):
    text: str


class Scan(Broadcast):
    ranges: Float32Array


class Weigh(Query[float]):
    pass


class Unheard(Inform):
    pass


@pytest.fixture
async def options():
    async with bus() as options:
        yield options


async def test_informs_are_handled_in_order_one_at_a_time(options):
    server = Module("server", options=options)
    got: list[int] = []
    busy = 0

    @server.handler(Note)
    async def note(message, context):
        nonlocal busy
        busy += 1
        assert busy == 1
        await asyncio.sleep(0)
        if message.number == 5:
            busy -= 1
            raise ValueError("one that fails does not stop the next")
        got.append(message.number)
        busy -= 1

    async with server, Module("sender", options=options) as sender:
        for number in range(20):
            await sender.inform(Note(number=number))
        await eventually(lambda: len(got) == 19)
        assert got == [number for number in range(20) if number != 5]


@pytest.mark.parametrize("way", [{"ordered": True}, {"clock": "sim"}])
async def test_what_one_module_sends_is_taken_in_that_order_whatever_it_is(options, way):
    options = options.model_copy(update=way)
    server, got = Module("server", options=options), []

    @server.handler(Note)
    async def note(message, context):
        got.append(message.number)

    @server.handler(Said)
    async def said(message, context):
        got.append(int(message.text))

    @server.handler(Weigh)
    async def weigh(message, context):
        got.append(-1)
        return 1.0

    async with server, Module("sender", options=options) as sender:
        await sender.query(Weigh())
        for number in range(0, 300, 3):
            await sender.broadcast(Said(text=str(number)))
            await sender.inform(Note(number=number + 1))
            asked = asyncio.create_task(sender.query(Weigh()), name="weigh")
            await asyncio.sleep(0)
            await sender.broadcast(Said(text=str(number + 2)))
            await asked
        await eventually(lambda: len(got) == 401)
    expected = [(number, number + 1, -1, number + 2) for number in range(0, 300, 3)]
    assert got == [-1, *(one for four in expected for one in four)]


async def test_many_informs_at_once_arrive_in_order_each_by_itself(options):
    server = Module("server", options=options)
    got: list[int] = []

    @server.handler(Note)
    async def note(message, context):
        assert context.sender == "sender"
        got.append(message.number)

    async with server, Module("sender", options=options) as sender:
        await sender.inform_many([Note(number=number) for number in range(600)])
        await sender.inform(Note(number=600))
        await sender.inform_many([])
        await eventually(lambda: len(got) == 601)
        assert got == list(range(601))
        with pytest.raises(NoHandlerError):
            await sender.inform_many([Note(number=1), Unheard()])


async def test_a_subscriber_hears_what_is_sent_after_it_was_entered(options):
    async with (
        Module("robot", options=options) as robot,
        Module("hearer", options=options) as hearer,
        hearer.subscribe(Scan) as scans,
        hearer.subscribe(Scan, size=2) as few,
    ):
        for number in range(5):
            await robot.broadcast(Scan(ranges=[float(number)]))
        heard = [(await scans.get()).ranges.tolist() for _ in range(5)]
        assert heard == [[float(number)] for number in range(5)]
        assert few.dropped == 3
        card = await hearer.query(Describe(), to="hearer")
        assert sum(card.dropped.values()) == 3
    with pytest.raises(ConfigError, match="Broadcast or Inform"):
        async with Module("late", options=options) as late:
            late.subscribe(Weigh)


async def test_many_broadcasts_at_once_reach_who_listens_arrays_too(options):
    async with (
        Module("robot", options=options) as robot,
        Module("hearer", options=options) as hearer,
        hearer.subscribe(Scan) as scans,
        hearer.subscribe(Said) as said,
    ):
        await robot.broadcast_many(
            [Said(text="a"), Scan(ranges=[1.0]), Scan(ranges=[2.0]), Said(text="b")]
        )
        assert [(await scans.get()).ranges.tolist() for _ in range(2)] == [[1.0], [2.0]]
        assert [(await said.get()).text for _ in range(2)] == ["a", "b"]


async def test_listening_to_a_broadcast_does_not_change_what_is_announced(options):
    async with (
        Module("hearer", options=options) as hearer,
        Module("watcher", options=options) as watcher,
        watcher.watch_modules() as changes,
    ):

        @hearer.handler(Scan)
        async def scan(message, context):
            pass

        first = {(await changes.get()).module.name for _ in range(2)}
        assert first == {"hearer", "watcher"}
        await watcher.query(Describe(), to="hearer")
        assert watcher._parts.core.presence.table.next_expiry() == float("inf")
        assert changes.waiting == 0
