"""Pools (tca.md 3.2) and queries to all (3.3): who is asked, who waits, who is let go."""

from __future__ import annotations

import asyncio
from contextlib import AsyncExitStack

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tca_bus import (
    BusyError,
    ConfigError,
    HandlerFailedError,
    Module,
    MultiQuery,
    Query,
    TaskError,
    TimedOutError,
)
from tca_bus._choice import Choice
from tca_bus._line import MOST_IN_LINE, PLACE_LEASE, Line
from tca_bus._presence import PresentModule
from tca_bus.testing import bus, eventually


class Plan(Query[str]):
    number: int = 0


class Survey(MultiQuery[str]):
    pass


def present(name):
    return PresentModule(name, f"{name}-1", "host", 1, ("plan",))


A, B, C = present("a"), present("b"), present("c")


def test_who_asks_one_thing_after_the_other_goes_round():
    choice = Choice()
    chosen = []
    for _ in range(6):
        one = choice.choose([A, B, C])
        choice.began(one.incarnation)
        choice.ended(one.incarnation)
        chosen.append(one.name)
    assert chosen == ["a", "b", "c", "a", "b", "c"]


def test_the_one_with_least_under_way_is_chosen():
    choice = Choice()
    for one in (A, B, C, A, C):
        choice.began(one.incarnation)
    assert choice.choose([A, B, C]) == B
    choice.ended(A.incarnation)
    choice.ended(A.incarnation)
    assert choice.choose([A, B, C]) == A
    assert choice.choose([A, B, C], busy=[A.incarnation, B.incarnation]) == C
    assert choice.choose([A], busy=[A.incarnation]) is None


def request(number):
    return ("caller", str(number))


def test_a_line_gives_places_in_order_of_arrival():
    line = Line(capacity=1)
    assert line.enter(request(1))
    assert not line.enter(request(2))
    assert line.wait(request(2), now=0.0) == []
    assert line.wait(request(3), now=0.0) == []
    assert line.leave(request(1), now=0.0) == [request(2)]
    assert not line.enter(request(4)), "a place that is kept was taken by another"
    assert line.enter(request(2))
    assert line.leave(request(2), now=0.0) == [request(3)]


def test_a_place_that_nobody_takes_goes_to_the_next():
    line = Line(capacity=1)
    line.enter(request(1))
    line.wait(request(2), now=0.0)
    line.wait(request(3), now=0.0)
    line.leave(request(1), now=10.0)
    assert line.next_expiry() == 10.0 + PLACE_LEASE
    assert line.expire(10.0 + PLACE_LEASE) == [request(3)]
    assert line.withdraw(request(3), now=12.0) == []
    assert line.enter(request(4))


class LineHistory:
    """A line under random calls."""

    def __init__(self, capacity):
        self.line = Line(capacity)
        self.handled = set()

    def step(self, action, number):
        one = request(number)
        if action == "enter" and self.line.enter(one):
            self.handled.add(one)
        elif action == "leave" and one in self.handled:
            self.handled.discard(one)
            self.line.leave(one, now=0.0)
        elif action == "wait":
            self.line.wait(one, now=0.0)
        elif action == "withdraw":
            self.line.withdraw(one, now=0.0)
        elif action == "expire":
            self.line.expire(now=PLACE_LEASE)

    @property
    def taken(self):
        return len(self.line._handled) + len(self.line._kept)


STEPS = st.tuples(
    st.sampled_from(["enter", "leave", "wait", "withdraw", "expire"]), st.integers(0, 5)
)


@settings(deadline=None)
@given(st.integers(1, 3), st.lists(STEPS, max_size=60))
def test_no_line_is_over_its_capacity_and_none_waits_beside_a_free_place(capacity, steps):
    history = LineHistory(capacity)
    for action, number in steps:
        history.step(action, number)
        assert history.line._handled == history.handled
        assert history.taken <= capacity
        assert not history.line.waiting or history.taken == capacity, "a place is free, one waits"


class Server:
    """Handles plans at a capacity, each until it is let go."""

    def __init__(self, name, options, capacity=1):
        self.name = name
        self.module = Module(name, options=options)
        self.module.serve(Plan, self.plan, capacity=capacity)
        self.go = asyncio.Event()
        self.handled: list[int] = []
        self.running = self.most = 0

    async def plan(self, message, context):
        self.handled.append(message.number)
        self.running += 1
        self.most = max(self.most, self.running)
        await self.go.wait()
        self.running -= 1
        return self.name


async def seen(asker, count):
    """Wait until so many servers are there for certain, none of them on hearsay."""
    table = asker.core.presence.table

    def certain():
        return [one for one in table.providers("plan") if table.state_of(one.incarnation)]

    await eventually(lambda: len(certain()) == count)


async def asked(asker, count):
    return [asyncio.create_task(asker.query(Plan(number=n), timeout=30.0)) for n in range(count)]


@pytest.mark.bus
async def test_queries_go_round_those_that_are_free():
    async with bus() as options, AsyncExitStack() as stack:
        servers = [Server(name, options, capacity=None) for name in "abc"]
        for server in servers:
            server.go.set()
            await stack.enter_async_context(server.module)
        asker = await stack.enter_async_context(Module("asker", options=options))
        await seen(asker, 3)
        answers = [await asker.query(Plan(number=n)) for n in range(6)]
        assert sorted(answers) == ["a", "a", "b", "b", "c", "c"]


@pytest.mark.bus
async def test_a_slow_one_does_not_hold_up_what_a_free_one_can_take():
    async with bus() as options:
        slow, quick = Server("a", options), Server("b", options)
        quick.go.set()
        async with slow.module, quick.module, Module("asker", options=options) as asker:
            await seen(asker, 2)
            plans = await asked(asker, 20)
            await eventually(lambda: sum(plan.done() for plan in plans) == 19)
            assert (len(slow.handled), len(quick.handled)) == (1, 19)
            assert (slow.most, quick.most) == (1, 1)
            slow.go.set()
            assert sorted(await asyncio.gather(*plans)) == ["a", *["b"] * 19]


@pytest.mark.bus
async def test_one_that_comes_later_takes_from_the_same_queue():
    async with bus() as options, Module("asker", options=options) as asker:
        slow, late = Server("a", options), Server("b", options)
        late.go.set()
        async with slow.module:
            await asker.wait_for(Plan, timeout=10.0)
            plans = await asked(asker, 4)
            await eventually(lambda: slow.running == 1)
            async with late.module:
                await eventually(lambda: sum(plan.done() for plan in plans) == 3)
                slow.go.set()
                assert sorted(await asyncio.gather(*plans)) == ["a", "b", "b", "b"]


@pytest.mark.bus
async def test_those_in_line_have_their_turn_in_order():
    async with bus() as options:
        server = Server("a", options)
        async with server.module, Module("asker", options=options) as asker:
            line = server.module._parts.server._turns
            plans = []
            for number in range(4):
                plans += [asyncio.create_task(asker.query(Plan(number=number), timeout=30.0))]
                await eventually(lambda n=number: len(server.handled) + waiting(line) == n + 1)
            server.go.set()
            await asyncio.gather(*plans)
            assert server.handled == [0, 1, 2, 3]


def waiting(turns):
    line = turns._line("plan")
    return 0 if line is None else line.waiting


@pytest.mark.bus
async def test_a_caller_that_gives_up_or_dies_leaves_the_line():
    async with bus() as options:
        server = Server("a", options)
        async with server.module, Module("asker", options=options) as asker:
            turns = server.module._parts.server._turns
            first = asyncio.create_task(asker.query(Plan(number=1)))
            await eventually(lambda: server.running == 1)
            with pytest.raises(TimedOutError):
                await asker.query(Plan(number=2), timeout=0.3)
            await eventually(lambda: waiting(turns) == 0)
            other = Module("other", options=options)
            await other.__aenter__()
            await other.wait_for(Plan, timeout=10.0)
            asking = asyncio.create_task(other.query(Plan(number=3)))
            await eventually(lambda: waiting(turns) == 1)
            await other._parts.core.session.close()
            await eventually(lambda: waiting(turns) == 0)
            asking.cancel()
            await asyncio.wait([asking])
            await other.__aexit__(None, None, None)
            server.go.set()
            assert await first == "a"
            assert server.handled == [1]


@pytest.mark.bus
async def test_a_line_that_is_full_is_busy(monkeypatch):
    monkeypatch.setattr("tca_bus._line.MOST_IN_LINE", 1)
    assert MOST_IN_LINE > 1
    async with bus() as options:
        server = Server("a", options)
        async with server.module, Module("asker", options=options) as asker:
            plans = await asked(asker, 2)
            await eventually(lambda: waiting(server.module._parts.server._turns) == 1)
            with pytest.raises(BusyError, match="has 1 waiting already"):
                await asker.query(Plan())
            server.go.set()
            await asyncio.gather(*plans)


class Surveyed:
    """Answers surveys when let go; notes those that were cancelled."""

    def __init__(self, name, options, *, error=None):
        self.name = name
        self.module = Module(name, options=options)
        self.module.serve(Survey, self.survey)
        self.go = asyncio.Event()
        self.error = error
        self.began = self.cancelled = 0

    async def survey(self, message, context):
        self.began += 1
        try:
            await self.go.wait()
        except asyncio.CancelledError:
            self.cancelled += 1
            raise
        if self.error is not None:
            raise self.error
        return self.name


@pytest.mark.bus
async def test_after_so_many_answers_the_others_are_let_go():
    async with bus() as options, Module("asker", options=options) as asker:
        slow, quick = Surveyed("a", options), Surveyed("b", options)
        broken = Surveyed("c", options, error=TaskError("broken", "no answer from here"))
        async with slow.module, quick.module, broken.module:
            await eventually(lambda: len(asker.modules()) == 4)
            async with asker.query_all(Survey(), most=1) as answers:
                following = asyncio.create_task(anext(answers))
                await eventually(lambda: slow.began and quick.began and broken.began)
                broken.go.set()
                await eventually(lambda: "c" in answers.failed)
                quick.go.set()
                assert await following == "b"
                assert [one async for one in answers] == []
            assert answers.asked == ("a", "b", "c")
            assert (answers.answered, answers.missing) == (["b"], ("a",))
            assert isinstance(answers.failed["c"], HandlerFailedError)
            await eventually(lambda: slow.cancelled == 1)


@pytest.mark.bus
async def test_a_time_limit_ends_the_waiting_and_names_who_is_missing():
    async with bus() as options, Module("asker", options=options) as asker:
        slow, quick = Surveyed("a", options), Surveyed("b", options)
        quick.go.set()
        async with slow.module, quick.module:
            await eventually(lambda: len(asker.modules()) == 3)
            answers = asker.query_all(Survey(), timeout=2.0)
            assert [one async for one in answers] == ["b"]
            assert answers.missing == ("a",)
            await eventually(lambda: slow.cancelled == 1)


@pytest.mark.bus
async def test_when_nobody_answers_the_end_says_why():
    async with bus() as options, Module("asker", options=options) as asker:
        slow = Surveyed("a", options)
        broken = Surveyed("b", options, error=TaskError("broken", "no answer from here"))
        async with slow.module:
            await asker.wait_for(Survey, timeout=10.0)
            with pytest.raises(TimedOutError, match="to all of a"):
                await anext(asker.query_all(Survey(), timeout=0.1))
        async with broken.module:
            broken.go.set()
            await eventually(lambda: [m.name for m in asker.modules()] == ["asker", "b"])
            with pytest.raises(ExceptionGroup) as caught:
                await anext(asker.query_all(Survey()))
            assert caught.group_contains(HandlerFailedError, match="broken")


def test_less_than_one_answer_is_no_number_of_answers():
    with pytest.raises(ConfigError, match="most is 0"):
        Module("asker").query_all(Survey(), most=0)
