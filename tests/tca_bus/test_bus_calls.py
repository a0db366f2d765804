"""Queries as they travel: published, answered, sent again, refused, given up."""

from __future__ import annotations

import asyncio
import json
import math
import queue
import threading

import pytest

from tca_bus import ClosedError, Module, PeerLostError, PresentModule, Query, TimedOutError
from tca_bus._bridge import Answer
from tca_bus._keys import Keys
from tca_bus._outlets import Outlets
from tca_bus._pending import Call, PendingCalls
from tca_bus._protocol import Describe
from tca_bus._session import Session
from tca_bus._wire import Payload
from tca_bus.testing import bus, eventually


class Ask(Query[int]):
    number: int


@pytest.fixture
async def options():
    async with bus() as options:
        yield options


@pytest.fixture
async def stranger(options):
    """A Zenoh program that is none of ours."""
    async with Session(options, on_transport=lambda _: None) as session:
        yield session.zenoh


def answering(options, seen):
    module = Module("server", options=options)

    @module.handler(Ask)
    async def ask(message, context):
        seen.append(message.number)
        return message.number + 1

    return module


class Seen:
    """What a stranger hears on a key."""

    def __init__(self, session, key):
        self.samples = []
        self._subscriber = session.declare_subscriber(key, self.samples.append)

    def ids(self):
        return [json.loads(sample.attachment.to_bytes())["id"] for sample in self.samples]


class FakeModule:
    """A stranger that announces itself as a module; it hears the calls and does as told."""

    def __init__(self, session, options, name="fake", incarnation="ff"):
        self.session = session
        self.keys = Keys(options.realm)
        self.me = PresentModule(name, incarnation, "host", 1, ("ask",))
        self.calls = Seen(session, self.keys.calls_to(name, incarnation))
        self.appear()

    def appear(self):
        self.token = self.session.liveliness().declare_token(self.keys.presence(self.me))

    def vanish(self):
        self.token.undeclare()

    def answer(self, asker, id, value, *, name=None):
        key = self.keys.answer(asker.name, asker.incarnation, name or self.me.name)
        self.session.put(key, json.dumps(value), attachment=id)


async def heard_by(asker, fake):
    """Ask in vain until the caller knows that the fake module listens to calls."""
    await asker.wait_for(Ask, timeout=10.0)

    async def is_heard():
        with pytest.raises(TimedOutError):
            await asker.query(Ask(number=0), timeout=0.02)
        return fake.calls.samples

    await eventually(is_heard)


@pytest.mark.bus
async def test_queries_and_answers_are_published_once_the_callee_is_known_to_listen(
    options, stranger
):
    seen: list[int] = []
    async with answering(options, seen), Module("asker", options=options) as asker:
        calls = Seen(stranger, f"{options.realm}/call/server/*/ask/asker")
        answers = Seen(stranger, f"{options.realm}/answer/asker/{asker.incarnation}/server")

        async def is_published():
            assert await asker.query(Ask(number=1)) == 2
            return calls.samples and answers.samples

        def answered():
            return [sample.attachment.to_string() for sample in answers.samples]

        await eventually(is_published)
        # One of the two may have begun to listen a question earlier than the other.
        await eventually(lambda: answered()[-1] == calls.ids()[-1])


@pytest.mark.bus
async def test_a_stranger_may_publish_a_query_and_hear_its_answer(options, stranger):
    seen: list[int] = []
    async with answering(options, seen) as server:
        answers = Seen(stranger, f"{options.realm}/answer/tool/t1/server")
        key = f"{options.realm}/call/server/{server.incarnation}/ask/tool"
        for _ in range(2):
            stranger.put(key, '{"number": 4}', attachment='{"id": "one", "sender": "t1"}')
        await eventually(lambda: len(answers.samples) == 2)
        assert [sample.payload.to_string() for sample in answers.samples] == ["5", "5"]
        assert [sample.attachment.to_string() for sample in answers.samples] == ["one", "one"]
        assert seen == [4]


@pytest.mark.bus
@pytest.mark.parametrize(
    "attachment", [None, b"\xff", '{"id": "one"}', '{"id": "one", "sender": "a/**"}']
)
async def test_a_published_query_without_a_way_back_is_counted(options, stranger, attachment):
    seen: list[int] = []
    async with answering(options, seen) as server:
        key = f"{options.realm}/call/server/{server.incarnation}/ask/tool"
        stranger.put(key, '{"number": 4}', attachment=attachment)

        async def invalid():
            return (await server.query(Describe(), to="server")).invalid == 1

        await eventually(invalid)
        assert seen == []


async def asking_fake(asker, stranger, options):
    """A stranger that has heard a call, the query under way, and how many calls came before it."""
    fake = FakeModule(stranger, options)
    await heard_by(asker, fake)
    before = len(fake.calls.samples)
    query = asyncio.create_task(asker.query(Ask(number=7)))
    await eventually(lambda: len(fake.calls.samples) > before)
    return fake, query, before


@pytest.mark.bus
async def test_only_the_module_that_was_asked_can_answer(options, stranger):
    async with Module("asker", options=options) as asker:
        fake, query, _ = await asking_fake(asker, stranger, options)
        id = fake.calls.ids()[-1]
        fake.answer(asker, id, 1, name="liar")
        fake.answer(asker, "another", 2)
        fake.answer(asker, id, 8)
        assert await query == 8
        fake.vanish()


@pytest.mark.bus
async def test_a_callee_that_vanished_and_is_back_is_sent_the_same_query_again(options, stranger):
    async with Module("asker", options=options) as asker:
        fake, query, before = await asking_fake(asker, stranger, options)
        fake.vanish()
        state_of = asker._parts.core.presence.table.state_of
        await eventually(lambda: state_of("ff") is None)
        fake.appear()
        await eventually(lambda: len(fake.calls.samples) > before + 1)
        assert len(set(fake.calls.ids()[before:])) == 1
        fake.answer(asker, fake.calls.ids()[-1], 8)
        assert await query == 8
        fake.vanish()


@pytest.mark.bus
async def test_a_silent_callee_is_asked_by_a_zenoh_query_with_the_same_id(
    options, stranger, monkeypatch
):
    monkeypatch.setattr("tca_bus._pending.PATIENCE", 0.05)
    asked: list[str] = []

    def reply(query):
        asked.append(json.loads(query.attachment.to_bytes())["id"])
        query.reply(query.key_expr, "9")

    async with Module("asker", options=options) as asker:
        fake = FakeModule(stranger, options)
        await heard_by(asker, fake)
        queryable = stranger.declare_queryable(f"{options.realm}/query/fake/ff/**", reply)
        assert await asker.query(Ask(number=8)) == 9
        assert asked[-1] == fake.calls.ids()[-1]
        queryable.undeclare()
        fake.vanish()


@pytest.mark.bus
async def test_a_callee_that_does_not_come_back_is_lost_and_nothing_of_it_is_kept(
    options, stranger
):
    async with Module("asker", options=options) as asker:
        fake = FakeModule(stranger, options)
        await heard_by(asker, fake)
        outlets = asker._parts.core.outlets
        before = len(outlets)
        query = asyncio.create_task(asker.query(Ask(number=7)))
        calls = len(fake.calls.samples)
        await eventually(lambda: len(fake.calls.samples) > calls)
        fake.vanish()
        with pytest.raises(PeerLostError, match="'fake'"):
            await query
        assert len(outlets) == before - 1


@pytest.mark.bus
async def test_a_query_that_is_given_up_leaves_nothing_behind(options):
    go = asyncio.Event()
    server = Module("server", options=options)

    @server.handler(Ask)
    async def ask(message, context):
        await go.wait()
        return message.number

    async with server, Module("asker", options=options) as asker:
        pending = asker._parts.caller._asking._pending
        query = asyncio.create_task(asker.query(Ask(number=1)))
        await eventually(lambda: len(pending) == 1)
        query.cancel()
        await asyncio.wait([query])
        assert query.cancelled()
        assert len(pending) == 0
        with pytest.raises(TimedOutError):
            await asker.query(Ask(number=2), timeout=0.02)
        assert len(pending) == 0
        go.set()


@pytest.mark.bus
async def test_what_is_under_way_when_its_module_closes_ends_as_closed(options, stranger):
    async with Module("asker", options=options) as asker:
        fake = FakeModule(stranger, options)
        await heard_by(asker, fake)
        query = asyncio.create_task(asker.query(Ask(number=1), timeout=math.inf))
        calls = len(fake.calls.samples)
        await eventually(lambda: len(fake.calls.samples) > calls)
    with pytest.raises(ClosedError):
        await query
    fake.vanish()


@pytest.mark.bus
async def test_calls_that_find_no_room_are_answered_as_busy(options, stranger, monkeypatch):
    monkeypatch.setattr("tca_bus._serving.MOST_WAITING", 3)
    seen: list[int] = []
    async with answering(options, seen) as server:
        answers = Seen(stranger, f"{options.realm}/answer/tool/t1/server")
        key = f"{options.realm}/call/server/{server.incarnation}/ask/tool"

        def flood():
            for number in range(10):
                attachment = json.dumps({"id": f"n{number}", "sender": "t1"})
                stranger.put(key, json.dumps({"number": number}), attachment=attachment)
            for _ in range(7):
                refusals.get(timeout=10.0)

        refusals = queue.Queue()
        watch = stranger.declare_subscriber(
            f"{options.realm}/answer/tool/t1/server", lambda _: refusals.put(1)
        )
        thread = threading.Thread(target=flood)
        thread.start()
        # The loop stands still meanwhile, on purpose.
        thread.join()
        await eventually(lambda: len(answers.samples) == 10)
        kinds = [json.loads(sample.payload.to_bytes()) for sample in answers.samples]
        busy = [kind for kind in kinds if isinstance(kind, dict)]
        assert {kind["error"] for kind in busy} == {"busy"}
        assert len(busy) == 10 - len(seen) == 7
        watch.undeclare()


@pytest.mark.bus
async def test_outlets_are_kept_for_the_keys_that_are_used(options):
    async with Module("asker", options=options) as asker:
        outlets = Outlets(asker._parts.core.session, most=2)
        first = outlets.at("a")
        outlets.at("b")
        assert outlets.at("a") is first
        outlets.at("c")
        assert len(outlets) == 2
        assert outlets.at("a") is first
        outlets.forget("a")
        outlets.forget("a")
        again = outlets.at("a")
        assert again is not first
        outlets.at("call/server/01/ask/asker")
        outlets.forget_module("01")
        assert len(outlets) == 1
        assert outlets.at("a") is again


def call(id, *, callee="server", incarnation="01", deadline=math.inf):
    future = asyncio.get_running_loop().create_future()
    to = PresentModule(callee, incarnation, "host", 1, ())
    return Call(id, "ask", to, Payload(b"{}", ""), b"{}", deadline, future)


async def test_a_call_is_due_when_patience_ends_and_then_at_its_deadline(monkeypatch):
    monkeypatch.setattr("tca_bus._pending.PATIENCE", 1.0)
    pending = PendingCalls()
    long, short = call("long", deadline=10.0), call("short", deadline=0.5)
    pending.add(long, 0.0)
    pending.add(short, 0.0)
    assert pending.next_due() == 0.5
    assert pending.take_due(0.5) == [short]
    pending.remove(short)
    assert pending.next_due() == 1.0
    assert pending.take_due(1.0) == [long]
    assert pending.next_due() == 10.0
    pending.remove(long)
    assert pending.next_due() == math.inf


async def test_an_answer_is_for_the_call_with_its_id_and_callee():
    pending = PendingCalls()
    one, other = call("1"), call("2", callee="other", incarnation="02")
    pending.add(one, 0.0)
    pending.add(other, 0.0)
    assert pending.find("1", "server") is one
    assert pending.find("1", "other") is None
    assert pending.find("3", "server") is None
    assert pending.to("02") == [other]


async def test_the_first_word_on_a_call_counts():
    answered, failed = call("1"), call("2")
    answer = Answer(Payload(b"1", ""), is_error=False)
    answered.settle(answer)
    answered.fail(TimeoutError())
    failed.fail(TimeoutError())
    failed.settle(answer)
    assert answered.answer.result() == answer
    assert isinstance(failed.answer.exception(), TimeoutError)


@pytest.mark.bus
async def test_an_answer_is_taken_once(options, monkeypatch):
    taken: list[str] = []
    find = PendingCalls.find

    def count(self, id, callee):
        taken.append(id)
        return find(self, id, callee)

    monkeypatch.setattr(PendingCalls, "find", count)
    async with answering(options, []), Module("asker", options=options) as asker:
        for number in range(3):
            assert await asker.query(Ask(number=number)) == number + 1
    assert len(taken) == len(set(taken))
