"""Clocks: active and passive waits, timeouts, and what is announced of them."""

from __future__ import annotations

import asyncio
import time

import pytest

from tca_bus import InvalidMessageError, SimulatedTime, TimedOutError
from tca_bus._clock import SimulatedClock, WallClock
from tca_bus._wire import Payload, decode_message
from tca_bus.testing import ManualClock, eventually


async def test_a_sleeper_wakes_when_its_time_has_come_and_not_before():
    clock = ManualClock(100.0)
    sleeper = asyncio.create_task(clock.sleep(5.0))
    await clock.advance(4.9)
    assert not sleeper.done()
    await clock.advance(0.1)
    await sleeper


async def test_sleepers_wake_in_the_order_of_their_times():
    clock = ManualClock()
    woken: list[float] = []

    async def sleep(seconds: float) -> None:
        await clock.sleep(seconds)
        woken.append(seconds)

    tasks = [asyncio.create_task(sleep(seconds)) for seconds in (3.0, 1.0, 2.0)]
    await asyncio.sleep(0)
    await clock.advance(10.0)
    await asyncio.gather(*tasks)
    assert woken == [1.0, 2.0, 3.0]


async def test_a_time_that_has_passed_is_no_wait():
    clock = ManualClock(10.0)
    for wait in (clock.sleep_until(9.0), clock.watch_until(10.0)):
        async with asyncio.timeout(5.0):
            await wait
    assert clock.now() == 10.0


async def test_a_timeout_is_on_the_clock():
    clock = ManualClock()

    async def limited() -> None:
        async with clock.timeout(2.0):
            await asyncio.Event().wait()

    task = asyncio.create_task(limited())
    await asyncio.sleep(0)
    await clock.advance(1.9)
    assert not task.done()
    await clock.advance(0.2)
    with pytest.raises(TimeoutError):
        await task


async def test_what_ends_in_time_is_left_alone():
    clock = ManualClock()
    async with clock.timeout(2.0):
        pass
    await clock.advance(10.0)
    assert clock.awaited() is None


def announcing():
    """A clock at 0, and what it announces: until when, and whether that makes time move."""
    told: list[tuple[float, bool] | None] = []
    clock = SimulatedClock(lambda wait: told.append(wait and (wait.until, wait.moves)))
    clock.move_to(0.0)
    return clock, told


async def test_the_earliest_wait_is_announced_and_whether_one_makes_time_move():
    clock, told = announcing()
    passive = asyncio.create_task(clock.watch_until(1.0))
    await eventually(lambda: told == [(1.0, False)])
    late = asyncio.create_task(clock.sleep_until(7.0))
    await eventually(lambda: told[-1] == (1.0, True))
    early = asyncio.create_task(clock.sleep_until(3.0))
    clock.move_to(1.0)
    await passive
    await eventually(lambda: told[-1] == (3.0, True))
    clock.move_to(5.0)
    await early
    await eventually(lambda: told[-1] == (7.0, True))
    late.cancel()
    await eventually(lambda: told[-1] is None)
    assert len(told) == 5


async def test_one_who_waits_again_at_once_is_announced_once():
    clock, told = announcing()

    async def beat() -> None:
        for when in (1.0, 2.0, 3.0):
            await clock.sleep_until(when)

    task = asyncio.create_task(beat())
    for now in (1.0, 2.0, 3.0):
        await eventually(lambda now=now: told and told[-1] == (now, True))
        clock.move_to(now)
    await task
    await eventually(lambda: told == [(1.0, True), (2.0, True), (3.0, True), None])


async def test_a_block_at_a_time_is_announced_until_it_is_left():
    clock, told = announcing()
    leave = asyncio.Event()
    inside: list[float] = []

    async def act() -> None:
        async with clock.at(2.0):
            inside.append(clock.now())
            await leave.wait()

    task = asyncio.create_task(act())
    await eventually(lambda: told == [(2.0, False)])
    clock.move_to(2.0)
    await eventually(lambda: inside == [2.0])
    for _ in range(5):
        await asyncio.sleep(0)
    assert told == [(2.0, False)]
    leave.set()
    await task
    await eventually(lambda: told == [(2.0, False), None])


async def test_a_block_that_holds_time_begins_at_once_and_ends_when_it_is_cancelled():
    clock, told = announcing()
    clock.move_to(4.0)

    async def act() -> None:
        with clock.hold():
            await asyncio.Event().wait()

    task = asyncio.create_task(act())
    await eventually(lambda: told == [(4.0, False)])
    task.cancel()
    await eventually(lambda: told == [(4.0, False), None])
    assert clock.awaited() is None


async def test_who_wakes_and_holds_time_lets_none_pass_between():
    clock, told = announcing()

    async def act() -> None:
        await clock.sleep_until(2.0)
        with clock.hold():
            await asyncio.sleep(0)

    task = asyncio.create_task(act())
    await eventually(lambda: told == [(2.0, True)])
    clock.move_to(2.0)
    await task
    await eventually(lambda: told == [(2.0, True), (2.0, False), None])


async def test_a_time_a_hair_before_is_that_time_and_reads_so():
    """Ticks are sums of floats: a tenth of a second 30 times over is not quite three."""
    clock = ManualClock()
    sleeper = asyncio.create_task(clock.sleep_until(3.0))
    await clock.advance(3.0 - 1e-7)
    await sleeper
    assert clock.now() >= 3.0


async def test_a_time_told_once_more_does_not_go_back_a_hair():
    clock, _ = announcing()
    sleeper = asyncio.create_task(clock.sleep_until(3.0))
    await asyncio.sleep(0)
    for _ in range(2):
        clock.move_to(3.0 - 1e-7)
        await sleeper
        assert clock.now() == 3.0
    clock.move_to(3.1)
    assert clock.now() == 3.1


async def test_simulated_time_is_unknown_until_it_is_told():
    clock = SimulatedClock()
    with pytest.raises(TimedOutError):
        clock.now()
    with pytest.raises(TimedOutError, match="simulated time"):
        await clock.wait_ready(0.01)
    clock.move_to(5.0)
    await clock.wait_ready(0.01)
    assert clock.now() == 5.0


async def test_time_may_go_back_after_a_restart_of_the_world():
    clock = ManualClock(100.0)
    sleeper = asyncio.create_task(clock.sleep_until(105.0))
    await asyncio.sleep(0)
    clock.move_to(90.0)
    await clock.advance(14.0)
    assert not sleeper.done()
    await clock.advance(1.0)
    await sleeper


async def test_the_wall_clock_is_the_wall():
    clock = WallClock()
    before = time.time()
    with clock.hold():
        async with clock.at(before):
            assert clock.now() >= before
    await clock.wait_ready(0.0)
    await clock.sleep(0.01)
    assert clock.now() >= before + 0.01
    with pytest.raises(TimeoutError):
        async with clock.timeout(0.01):
            await asyncio.Event().wait()


class Dial:
    """The time of day, as somebody sets it; counts how often it is looked at."""

    def __init__(self, monkeypatch, at):
        self.at = at
        self.looks = 0
        monkeypatch.setattr("tca_bus._clock.time", self)
        monkeypatch.setattr("tca_bus._clock.LONGEST_NAP", 0.001)

    def time(self):
        self.looks += 1
        return self.at


async def test_a_clock_that_is_set_forward_wakes_those_whose_time_has_come(monkeypatch):
    dial = Dial(monkeypatch, 1000.0)
    waiting = asyncio.create_task(WallClock().sleep_until(90_000.0))
    await eventually(lambda: dial.looks > 3)
    assert not waiting.done()
    dial.at = 90_000.0
    await waiting


async def test_a_clock_that_is_set_back_lets_nobody_go_early(monkeypatch):
    dial = Dial(monkeypatch, 1000.0)
    waiting = asyncio.create_task(WallClock().sleep_until(1000.001))
    await eventually(lambda: dial.looks > 0)
    dial.at = 500.0
    before = dial.looks
    await eventually(lambda: dial.looks > before + 5)
    assert not waiting.done()
    dial.at = 1000.001
    await waiting


@pytest.mark.parametrize("time", ["NaN", "Infinity", "-Infinity"])
def test_a_simulated_time_that_is_no_number_is_invalid(time):
    payload = Payload(f'{{"time": {time}, "speed": null}}'.encode(), "application/json")
    with pytest.raises(InvalidMessageError, match="time: input should be a finite number"):
        decode_message(payload, SimulatedTime)
