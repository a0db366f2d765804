"""Whatever arrives on our keys is answered or dropped, counted, and harms nothing."""

from __future__ import annotations

import asyncio
import json
import math
import random
import sys
from pathlib import Path

import pytest
import zenoh

from tca_bus import Broadcast, Inform, InvalidMessageError, Module, Query, RefusedError
from tca_bus._joining import client_config
from tca_bus._keys import Keys
from tca_bus._protocol import Describe
from tca_bus.testing import bus, eventually

pytestmark = pytest.mark.bus

NOISE = random.Random(7).randbytes(1_000_000)


class Ask(Query[int]):
    number: int


class Tell(Inform):
    number: int


class Shout(Broadcast):
    number: int


@pytest.fixture
async def options():
    async with bus() as options:
        yield options


@pytest.fixture
async def stranger(options):
    """A Zenoh program that is none of ours."""
    session = await asyncio.to_thread(zenoh.open, client_config(options))
    yield session
    await asyncio.to_thread(session.close)


def replies(session, key, payload, attachment=None):
    """Ask as a plain Zenoh program; runs on a thread."""
    found = session.get(key, payload=payload, attachment=attachment, timeout=5.0)
    return [(reply.ok, reply.err) for reply in found]


async def test_a_megabyte_of_noise_on_every_key_is_harmless(options, stranger):
    told: list[int] = []
    server = Module("server", options=options)

    @server.handler(Ask)
    async def ask(message, context):
        return message.number

    @server.handler(Tell)
    async def tell(message, context):
        told.append(message.number)

    async with (
        server,
        Module("asker", options=options) as asker,
        server.subscribe(Shout) as shouts,
    ):
        keys = Keys(options.realm)
        for key in (
            keys.one_way("inform", "tell", "x"),
            keys.one_way("broadcast", "shout", "x"),
            keys.task("server", "x"),
            keys.presence(asker.modules()[0]).replace("/presence/", "/presence/extra/"),
        ):
            await asyncio.to_thread(
                stranger.put, key, NOISE, congestion_control=zenoh.CongestionControl.BLOCK
            )
        base = f"{options.realm}/query/server/{server.incarnation}"
        for key in (f"{base}/ask/x", f"{base}/tca.handle/x", f"{base}/nothing/x", f"{base}/short"):
            answers = await asyncio.to_thread(replies, stranger, key, NOISE)
            assert len(answers) == 1
            assert answers[0][1] is not None
            assert json.loads(answers[0][1].payload.to_bytes())["error"] in {
                "invalid",
                "no_handler",
            }
        assert await asker.query(Ask(number=5)) == 5
        await asker.inform(Tell(number=6))
        await asker.broadcast(Shout(number=7))
        await eventually(lambda: told == [6])
        assert (await shouts.get()).number == 7
        card = await asker.query(Describe(), to="server")
        assert card.invalid == 6


async def test_a_bad_attachment_is_an_error_reply(options, stranger):
    server = Module("server", options=options)

    @server.handler(Ask)
    async def ask(message, context):
        return message.number

    async with server:
        key = f"{options.realm}/query/server/{server.incarnation}/ask/x"
        answers = await asyncio.to_thread(replies, stranger, key, b'{"number": 1}', NOISE[:1000])
        assert [error is not None for _, error in answers] == [True]


@pytest.mark.parametrize("name", ["", "a/b", "a#b", "**", "two words", "x" * 200])
async def test_what_cannot_be_a_name_is_not_sent(options, name):
    async with Module("asker", options=options) as asker:
        with pytest.raises(InvalidMessageError, match="name: expected 1 to 100 letters"):
            await asker.query_json(name, {}, to="asker")
        with pytest.raises(InvalidMessageError, match="name: expected 1 to 100 letters"):
            await asker.inform_json(name, {})
        with pytest.raises(InvalidMessageError, match="name: expected 1 to 100 letters"):
            await asker.broadcast_json(name, {})


async def test_a_query_may_wait_without_end(options):
    server = Module("server", options=options)

    @server.handler(Ask)
    async def ask(message, context):
        return message.number

    async with server:
        assert await server.query(Ask(number=3), timeout=math.inf) == 3


async def test_a_subscription_that_is_cancelled_on_entering_leaves_nothing(options):
    async with Module("listener", options=options) as listener:
        before = set(listener._parts.topics._topics)
        entering = asyncio.create_task(listener.subscribe(Shout).__aenter__())
        await asyncio.sleep(0)
        assert set(listener._parts.topics._topics) > before
        entering.cancel()
        await asyncio.wait([entering])
        assert entering.cancelled()
        assert set(listener._parts.topics._topics) == before


@pytest.mark.process
async def test_a_module_that_leaves_off_listening_does_not_freeze():
    # In a process of its own: one that freezes so holds the GIL and could not end this test.
    fickle = str(Path(__file__).with_name("bus_fickle.py"))
    process = await asyncio.create_subprocess_exec(sys.executable, fickle, "1000")
    try:
        async with asyncio.timeout(40.0):
            assert await process.wait() == 0
    finally:
        if process.returncode is None:
            process.kill()
            await process.wait()


async def test_plain_zenoh_programs_may_ask_with_json_and_wildcards(options, stranger):
    server = Module("server", options=options)

    @server.handler(Ask)
    async def ask(message, context):
        return message.number + 1

    async with server:
        key = f"{options.realm}/query/server/*/ask/*"
        answers = await asyncio.to_thread(replies, stranger, key, b'{"number": 1}')
        assert [ok.payload.to_string() for ok, _ in answers] == ["2"]


async def test_a_token_that_is_none_of_ours_is_ignored(options, stranger):
    async with Module("server", options=options) as server:
        token = stranger.liveliness().declare_token(f"{options.realm}/presence/odd")
        other = stranger.liveliness().declare_token(f"{options.realm}/presence/a/b/c/pid/e")

        async def is_counted() -> bool:
            return (await server.query(Describe(), to="server")).invalid >= 2

        await eventually(is_counted)
        assert [module.name for module in server.modules()] == ["server"]
        token.undeclare()
        other.undeclare()


async def test_a_request_that_comes_twice_is_handled_once(options, stranger):
    server = Module("server", options=options)
    seen: list[int] = []

    @server.handler(Ask)
    async def ask(message, context):
        seen.append(message.number)
        return len(seen)

    async with server:
        key = f"{options.realm}/query/server/{server.incarnation}/ask/x"
        for _ in range(3):
            answers = await asyncio.to_thread(
                replies, stranger, key, b'{"number": 1}', b'{"id": "same"}'
            )
            assert [ok.payload.to_string() for ok, _ in answers] == ["1"]
        assert seen == [1]
        other = f"{options.realm}/query/server/{server.incarnation}/nothing/x"
        answers = await asyncio.to_thread(replies, stranger, other, b"{}", b'{"id": "same"}')
        assert [error is not None for _, error in answers] == [True], "an id is not the message"


async def test_a_loop_that_stands_still_loses_the_oldest_and_says_how_many(options, stranger):
    async with Module("server", options=options) as server, server.subscribe(Shout) as shouts:
        key = Keys(options.realm).one_way("broadcast", "shout", "x")

        def flood() -> None:
            for number in range(6000):
                stranger.put(
                    key,
                    json.dumps({"number": number}),
                    congestion_control=zenoh.CongestionControl.BLOCK,
                )

        await asyncio.to_thread(flood)
        last = -1
        while last != 5999:
            last = (await shouts.get()).number
        card = await server.query(Describe(), to="server")
        assert sum(card.dropped.values()) >= shouts.dropped


async def test_too_many_queries_at_once_are_refused_not_lost(options, monkeypatch):
    monkeypatch.setattr("tca_bus._serving.MOST_RUNNING", 3)
    server = Module("server", options=options)
    go = asyncio.Event()
    running: list[int] = []

    @server.handler(Ask)
    async def ask(message, context):
        running.append(message.number)
        await go.wait()
        return message.number

    async with server, Module("asker", options=options) as asker:
        first = [asyncio.create_task(asker.query(Ask(number=n))) for n in range(3)]
        await eventually(lambda: len(running) == 3)
        with pytest.raises(RefusedError, match="too many"):
            await asker.query(Ask(number=4))
        go.set()
        assert await asyncio.gather(*first) == [0, 1, 2]


async def test_an_answer_that_does_not_fit_is_an_invalid_message(options, stranger):
    async with Module("asker", options=options) as asker:
        realm, incarnation = options.realm, "ff"
        queryable = stranger.declare_queryable(
            f"{realm}/query/fake/{incarnation}/**",
            lambda query: query.reply(query.key_expr, NOISE),
        )
        token = stranger.liveliness().declare_token(
            f"{realm}/presence/fake/{incarnation}/host/1/ask"
        )
        await asker.wait_for(Ask, timeout=10.0)
        with pytest.raises(InvalidMessageError, match=r"ask\.reply"):
            await asker.query(Ask(number=1))
        token.undeclare()
        queryable.undeclare()
