"""Modules talk over a real router."""

from __future__ import annotations

import asyncio
import time

import pytest
from pydantic import BaseModel

from tca_bus import (
    BusGoneError,
    BusOptions,
    ClosedError,
    ConfigError,
    HandlerFailedError,
    Inform,
    InvalidMessageError,
    Module,
    MultiQuery,
    NoHandlerError,
    Query,
    RefusedError,
    Router,
    TaskError,
    TimedOutError,
)
from tca_bus._heartbeat import Heartbeat
from tca_bus._protocol import Describe, ModuleCard
from tca_bus._time_messages import AwaitTime
from tca_bus.testing import TimeSource, bus, eventually

pytestmark = pytest.mark.bus


class Sum(BaseModel):
    value: int


class Add(Query[Sum]):
    """Add two numbers."""

    a: int
    b: int


class Echo(Query[str]):
    text: str


class Wait(Query[None]):
    number: int


class Survey(MultiQuery[str]):
    pass


class Note(Inform):
    number: int


@pytest.fixture
async def options():
    async with bus() as options:
        yield options


async def test_a_query_is_answered_with_the_type_that_it_names(options):
    server = Module("server", options=options)

    @server.handler(Add)
    async def add(message, context):
        assert context.sender == "asker"
        assert context.module is server
        return Sum(value=message.a + message.b)

    async with server, Module("asker", options=options) as asker:
        answer = await asker.query(Add(a=2, b=3))
        assert answer == Sum(value=5)
        assert await asker.query_json("add", {"a": 1, "b": 1}) == {"value": 2}
        assert await asker.query(Add(a=2, b=2), to="server") == Sum(value=4)


async def test_a_module_may_ask_itself(options):
    async def add(message, context):
        return Sum(value=message.a + message.b)

    module = Module("both", options=options)
    module.serve(Add, add)
    async with module:
        assert await module.query(Add(a=1, b=2)) == Sum(value=3)


async def test_many_queries_are_handled_at_once(options):
    server = Module("server", options=options)
    running: set[int] = set()
    go = asyncio.Event()

    @server.handler(Wait)
    async def wait(message, context):
        running.add(message.number)
        await go.wait()

    async with server, Module("asker", options=options) as asker, asyncio.TaskGroup() as group:
        for number in range(50):
            group.create_task(asker.query(Wait(number=number)))
        await eventually(lambda: len(running) == 50)
        go.set()


async def test_what_a_handler_raises_reaches_the_caller_as_what_it_was(options):
    errors = {
        "named": TaskError("unlucky", "not today", data={"day": 13}),
        "refused": RefusedError("that", "no"),
        "bug": ZeroDivisionError("oops"),
        "nobody": NoHandlerError("other"),
    }
    server = Module("server", options=options)

    @server.handler(Echo)
    async def echo(message, context):
        raise errors[message.text]

    async with server, Module("asker", options=options) as asker:
        with pytest.raises(HandlerFailedError) as named:
            await asker.query(Echo(text="named"))
        assert named.value.failure.name == "unlucky"
        assert named.value.failure.data == {"day": 13}
        with pytest.raises(RefusedError, match="that was refused: no"):
            await asker.query(Echo(text="refused"))
        with pytest.raises(HandlerFailedError, match="ZeroDivisionError: oops"):
            await asker.query(Echo(text="bug"))
        with pytest.raises(NoHandlerError, match="'other'"):
            await asker.query(Echo(text="nobody"))


async def test_nobody_handles_it_is_said_at_once_with_near_names(options):
    server = Module("server", options=options)

    @server.handler(Add)
    async def add(message, context):
        return Sum(value=0)

    async with server, Module("asker", options=options) as asker:
        with pytest.raises(NoHandlerError, match="Did you mean 'add'"):
            await asker.query_json("ad", {})
        with pytest.raises(NoHandlerError, match="Did you mean 'server:add'"):
            await asker.query(Add(a=1, b=1), to="serve")
        with pytest.raises(NoHandlerError, match="'tca modules' lists who is there"):
            await asker.query(Add(a=1, b=1), to="central")
        with pytest.raises(NoHandlerError, match="'echo'"):
            await asker.query(Echo(text=""), to="server")
        with pytest.raises(NoHandlerError):
            await asker.inform(Note(number=1))


async def test_a_query_that_does_not_fit_says_which_field_and_is_counted(options):
    server = Module("server", options=options)

    @server.handler(Add)
    async def add(message, context):
        return Sum(value=0)

    async with server, Module("asker", options=options) as asker:
        with pytest.raises(InvalidMessageError, match="b: input should be a valid integer"):
            await asker.query_json("add", {"a": 1, "b": "two"})
        card = await asker.query(Describe(), to="server")
        assert isinstance(card, ModuleCard)
        assert card.invalid == 1
        assert [provided.name for provided in card.provides] == ["add"]
        assert card.provides[0].message_schema["properties"].keys() == {"a", "b"}


async def test_an_answer_of_the_wrong_type_is_the_handlers_failure(options):
    server = Module("server", options=options)

    @server.handler(Add)
    async def add(message, context):
        return "five"

    async with server, Module("asker", options=options) as asker:
        with pytest.raises(HandlerFailedError, match="invalid_answer"):
            await asker.query(Add(a=2, b=3))


async def test_no_answer_in_time_is_a_timeout_and_the_handler_goes_on(options):
    server = Module("server", options=options)
    begun, go, done = asyncio.Event(), asyncio.Event(), asyncio.Event()

    @server.handler(Wait)
    async def wait(message, context):
        begun.set()
        await go.wait()
        done.set()

    async with server, Module("asker", options=options) as asker:
        with pytest.raises(TimedOutError):
            await asker.query(Wait(number=1), timeout=0.05)
        await begun.wait()
        go.set()
        await done.wait()
        assert await asker.query(Wait(number=2)) is None


async def test_modules_are_seen_when_they_come_and_when_they_go(options):
    async with Module("watcher", options=options) as watcher, watcher.watch_modules() as changes:
        first = await changes.get()
        assert (first.module.name, first.appeared) == ("watcher", True)
        guest = Module("guest", options=options)

        @guest.handler(Add)
        async def add(message, context):
            return Sum(value=0)

        async with guest:
            await watcher.wait_for(Add, timeout=10.0)
            came = await changes.get()
            assert (came.module.name, came.module.provides, came.appeared) == (
                "guest",
                ("add",),
                True,
            )
            assert [module.name for module in watcher.modules()] == ["guest", "watcher"]
        left = await changes.get()
        assert (left.module.name, left.appeared) == ("guest", False)
        with pytest.raises(TimedOutError, match="'add'"):
            await watcher.wait_for(Add, timeout=0.05)


async def test_a_handler_may_be_registered_while_the_module_is_open(options):
    async with Module("server", options=options) as server, Module("a", options=options) as asker:

        @server.handler(Echo)
        async def echo(message, context):
            return message.text

        await asker.wait_for(Echo, timeout=10.0)
        assert await asker.query(Echo(text="late")) == "late"


async def test_the_newest_of_two_modules_of_one_name_answers(options):
    def server(text):
        module = Module("server", options=options)

        async def echo(message, context):
            return text

        module.serve(Echo, echo)
        return module

    async with server("old"):
        started = time.time_ns() // 1_000_000
        # Which of those is newer that start within one millisecond is left to chance.
        await eventually(lambda: time.time_ns() // 1_000_000 > started)
        async with server("new"), Module("asker", options=options) as asker:
            assert await asker.query(Echo(text="")) == "new"


async def test_a_query_to_all_gets_every_answer_the_fastest_first(options):
    gate = asyncio.Event()

    def server(name, answer):
        module = Module(name, options=options)
        module.serve(Survey, answer)
        return module

    async def quick(message, context):
        return "quick"

    async def slow(message, context):
        await gate.wait()
        return "slow"

    async def broken(message, context):
        raise TaskError("broken", "no answer from here")

    async with (
        server("a", slow),
        server("b", quick),
        server("c", broken),
        Module("asker", options=options) as asker,
    ):
        answers = asker.query_all(Survey())
        assert await anext(answers) == "quick"
        gate.set()
        assert await anext(answers) == "slow"
        assert [one async for one in answers] == []
        assert answers.asked == ("a", "b", "c")
        assert answers.answered == ["b", "a"]
        assert isinstance(answers.failed["c"], HandlerFailedError)
        assert answers.missing == ()


async def test_a_query_to_all_of_none_says_so(options):
    async with Module("asker", options=options) as asker:
        with pytest.raises(NoHandlerError):
            await anext(asker.query_all(Survey()))


async def test_realms_do_not_meet(options):
    server = Module("server", options=options)

    @server.handler(Echo)
    async def echo(message, context):
        return message.text

    elsewhere = options.model_copy(update={"realm": "elsewhere"})
    async with server, Module("asker", options=elsewhere) as asker:
        with pytest.raises(NoHandlerError):
            await asker.query(Echo(text=""))


async def test_a_background_task_that_fails_ends_the_module(options):
    async def fail() -> None:
        raise ValueError("broken")

    server = Module("server", options=options)

    async def serve() -> None:
        async with server:
            server.start(fail(), name="fails")
            await server.serve_forever()

    with pytest.raises(ValueError, match="broken"):
        await serve()
    with pytest.raises(ClosedError):
        server.modules()
    with pytest.raises(ClosedError):
        await server.__aenter__()


async def test_an_error_in_the_body_comes_out_as_itself(options):
    with pytest.raises(KeyError):
        async with Module("server", options=options):
            raise KeyError("mine")


async def test_a_cancelled_module_ends_its_handlers(options):
    ended = asyncio.Event()
    begun = asyncio.Event()

    async def serve() -> None:
        module = Module("server", options=options)

        @module.handler(Wait)
        async def wait(message, context):
            begun.set()
            try:
                await asyncio.Event().wait()
            finally:
                ended.set()

        async with module:
            await module.serve_forever()

    task = asyncio.create_task(serve())
    async with Module("asker", options=options) as asker:
        await asker.wait_for(Wait, timeout=10.0)
        query = asyncio.create_task(asker.query(Wait(number=1)))
        await begun.wait()
        task.cancel()
        with pytest.raises(asyncio.CancelledError):
            await task
        assert ended.is_set()
        with pytest.raises(Exception, match="server"):
            await query


async def test_without_a_router_joining_fails_with_what_to_do():
    async with Router("tcp/127.0.0.1:0") as router:
        endpoint = router.endpoint
    options = BusOptions(connect=endpoint, connect_timeout=0.1)
    with pytest.raises(BusGoneError, match="tca router") as caught:
        async with Module("alone", options=options):
            pass
    assert caught.value.endpoint == endpoint


async def test_a_port_in_use_is_a_clear_error():
    async with Router("tcp/127.0.0.1:0") as router:
        with pytest.raises(ConfigError, match="something listens there already"):
            async with Router(router.endpoint):
                pass


async def test_heartbeats_come_through_the_loop(options):
    async with (
        Module("listener", options=options) as listener,
        listener.subscribe(Heartbeat) as beats,
        Module("server", options=options) as server,
    ):
        while (beat := await beats.get()).module != "server":
            pass
        assert beat.incarnation == server.incarnation


async def test_simulated_time_comes_over_the_bus_and_waits_are_announced(options):
    simulated = options.model_copy(update={"clock": "sim"})
    async with (
        Module("xavier", options=options) as xavier,
        xavier.subscribe(AwaitTime) as waits,
        Module("navigate", options=simulated) as navigate,
    ):
        source = TimeSource(xavier, start=1000.0)
        await source.tell()
        await navigate.clock.wait_ready(5.0)
        sleeper = asyncio.create_task(navigate.clock.sleep(2.0))
        assert (await waits.get()).until == 1002.0
        await source.advance(1.0)
        await source.advance(1.0)
        await sleeper
        assert navigate.clock.now() == 1002.0
        while (await waits.get()).until is not None:
            pass
