"""Things on a real bus: leases, rings of waits, and what ends a lease."""

from __future__ import annotations

import asyncio
import signal

import pytest
from bus_process import joining
from mortal_router import MortalRouter
from resource_holder import Ride
from resource_office import asked, holders, pair, resource, waiters, waiting

from tca_bus import (
    DeadlockError,
    InvalidMessageError,
    LeaseLostError,
    Module,
    PendingLimitError,
    RefusedError,
    TaskFailedError,
    TimedOutError,
)
from tca_bus._protocol import ReadLog
from tca_bus._resource_messages import UnlockResource
from tca_bus.testing import bus, central, eventually

pytestmark = pytest.mark.bus


async def test_a_thing_is_held_by_one_at_a_time():
    async with pair() as (one, two):
        async with one.acquire("lift") as lease:
            assert lease.is_held
            later = waiting(two, "lift")
            await eventually(lambda: waiters(one, "lift"))
            assert await holders(one, "lift") == ["one"]
        assert not lease.is_held
        theirs = await asyncio.wait_for(later, 10.0)
        assert await holders(one, "lift") == ["two"]
        await theirs.release()
        assert await resource(one, "lift") is None


async def test_several_things_are_taken_at_once():
    async with pair() as (one, two):
        lift = await one.acquire("lift")
        both = waiting(two, "lift", "door")
        await eventually(lambda: waiters(one, "door"))
        assert await holders(one, "door") == []
        await lift.release()
        lease = await asyncio.wait_for(both, 10.0)
        assert lease.names == ("lift", "door")
        assert await holders(one, "door") == await holders(one, "lift") == ["two"]


async def test_a_wait_that_takes_too_long_says_who_has_it_and_is_withdrawn():
    async with pair() as (one, two), one.acquire("lift"):
        with pytest.raises(TimedOutError, match=r"waiting for lift \(lift, which one has\)"):
            await two.acquire("lift", timeout=2.0)
        await eventually(lambda: _none(waiters(one, "lift")))


async def _none(found):
    return not await found


async def test_a_cancelled_wait_is_withdrawn():
    async with pair() as (one, two), one.acquire("lift"):
        later = waiting(two, "lift")
        await eventually(lambda: waiters(one, "lift"))
        later.cancel()
        await eventually(lambda: _none(waiters(one, "lift")))


async def test_a_declared_thing_has_more_places_and_a_limit():
    async with pair() as (one, two):
        await one.declare("chargers", capacity=2, pending=1)
        held = [await one.acquire("chargers"), await two.acquire("chargers")]
        first = waiting(one, "chargers")
        await eventually(lambda: waiters(one, "chargers"))
        second = waiting(two, "chargers")
        with pytest.raises(PendingLimitError, match="more than 1 waited"):
            await asyncio.wait_for(first, 10.0)
        assert (await resource(one, "chargers")).dropped == 1
        await held[0].release()
        assert (await asyncio.wait_for(second, 10.0)).is_held
        with pytest.raises(InvalidMessageError, match="capacity"):
            await one.declare("chargers", capacity=0)


async def test_a_ring_is_refused_and_names_its_members():
    async with pair() as (one, two):

        async def hold_then(module, first, then, event):
            async with module.acquire(first):
                event.set()
                await both.wait()
                async with module.acquire(then):
                    pass

        both, here, there = asyncio.Event(), asyncio.Event(), asyncio.Event()
        tasks = [
            asyncio.ensure_future(hold_then(one, "lift", "door", here)),
            asyncio.ensure_future(hold_then(two, "door", "lift", there)),
        ]
        await here.wait()
        await there.wait()
        both.set()
        results = await asyncio.gather(*tasks, return_exceptions=True)
        refused = [result for result in results if result is not None]
        assert len(refused) == 1
        assert isinstance(refused[0], DeadlockError)
        assert len(refused[0].members) == 4
        assert "holding lift" in str(refused[0])


async def test_another_asyncio_task_that_waits_is_no_ring():
    async with pair() as (one, two):
        theirs = await two.acquire("door")
        async with one.acquire("lift"):
            later = waiting(one, "door")
            await eventually(lambda: waiters(one, "door"))
            inner = waiting(two, "lift")
            await eventually(lambda: waiters(one, "lift"))
        assert (await asyncio.wait_for(inner, 10.0)).is_held
        await theirs.release()
        assert (await asyncio.wait_for(later, 10.0)).is_held


async def test_what_is_unlocked_by_hand_ends_the_block_of_its_holder():
    async with pair() as (one, two):
        entered, after = asyncio.Event(), []

        async def ride():
            async with one.acquire("lift"):
                entered.set()
                await asyncio.get_running_loop().create_future()
            after.append("not reached")

        riding = asyncio.ensure_future(ride())
        await entered.wait()
        ended = await two.query(UnlockResource(name="lift"))
        assert [status.module for status in ended] == ["one"]
        with pytest.raises(LeaseLostError, match="unlocked by two"):
            await asyncio.wait_for(riding, 10.0)
        assert after == []
        assert riding.cancelling() == 0
        assert await resource(one, "lift") is None


async def test_a_kept_lease_says_when_it_is_lost():
    async with pair() as (one, two):
        lease = await one.acquire("lift")
        lost = asyncio.ensure_future(lease.lost())
        await two.query(UnlockResource(name="lift"))
        assert "unlocked by two" in str(await asyncio.wait_for(lost, 10.0))
        assert not lease.is_held


async def test_nobody_gives_back_what_is_anothers():
    async with pair() as (one, two):
        lease = await one.acquire("lift")
        with pytest.raises(RefusedError, match="it is of 'one'"):
            await two.query_json("tca.release", {"id": lease.id})
        with pytest.raises(RefusedError, match="not handling try 1"):
            await two.query_json(
                "tca.acquire", {"id": "x", "names": ["lift"], "task": "none", "attempt": 1}
            )


async def test_leases_end_with_their_module():
    async with pair() as (one, two):
        async with Module("brief", options=one.options) as brief:
            await brief.acquire("lift")
            later = waiting(two, "lift")
            await eventually(lambda: waiters(one, "lift"))
        assert (await asyncio.wait_for(later, 10.0)).is_held


@pytest.mark.process
async def test_a_killed_process_holds_nothing():
    async with (
        pair() as (one, two),
        joining("resource_holder.py", one.options, "lift", "door") as process,
    ):
        await eventually(lambda: holders(one, "lift"))
        later = waiting(two, "door")
        await eventually(lambda: waiters(one, "door"))
        process.send_signal(signal.SIGKILL)
        assert (await asyncio.wait_for(later, 10.0)).is_held
        assert await resource(one, "lift") is None


@pytest.mark.process
async def test_a_killed_handler_holds_nothing():
    async with pair() as (one, two), joining("resource_holder.py", one.options) as process:
        await one.wait_for(Ride, timeout=20.0)
        task = await one.execute(Ride(thing="lift"))
        await eventually(lambda: holders(one, "lift"))
        later = waiting(two, "lift")
        await eventually(lambda: waiters(one, "lift"))
        process.send_signal(signal.SIGKILL)
        assert (await asyncio.wait_for(later, 10.0)).is_held
        with pytest.raises(TaskFailedError, match="module_lost"):
            await task.result(timeout=10.0)


async def test_holds_survive_a_restart_of_central(tmp_path):
    async with (
        bus() as options,
        Module("one", options=options) as one,
        Module("two", options=options) as two,
    ):
        async with central(options, data=tmp_path):
            lift = await one.acquire("lift")
            await one.declare("chargers", capacity=3)
            later = waiting(two, "lift")
            await eventually(lambda: waiters(one, "lift"))
        async with central(options, data=tmp_path):
            await eventually(lambda: asked(one, "lift"))
            assert await holders(one, "lift") == ["one"]
            assert await waiters(one, "lift") == ["two"]
            assert (await resource(one, "chargers")).capacity == 3
            await lift.release()
            assert (await asyncio.wait_for(later, 10.0)).is_held


async def test_a_holder_that_died_with_central_holds_nothing(tmp_path):
    async with bus() as options, Module("two", options=options) as two:
        async with Module("one", options=options) as one, central(options, data=tmp_path):
            await one.acquire("lift")
            later = waiting(two, "lift")
            await eventually(lambda: waiters(two, "lift"))
        async with central(options, data=tmp_path):
            assert (await asyncio.wait_for(later, 20.0)).is_held


async def test_a_new_central_that_knows_nothing_ends_what_it_does_not_know():
    async with bus() as options, Module("one", options=options) as one:
        async with central(options):
            lift = await one.acquire("lift")
        async with central(options):
            error = await asyncio.wait_for(lift.lost(), 10.0)
            assert "does not know" in str(error)


async def test_leases_survive_a_restart_of_the_router():
    async with (
        MortalRouter() as router,
        central(router.options),
        Module("one", options=router.options) as one,
        Module("two", options=router.options) as two,
    ):
        lift = await one.acquire("lift")
        later = waiting(two, "lift")
        await eventually(lambda: waiters(one, "lift"))
        await router.die()
        await eventually(lambda: not one.is_connected)
        await router.rise()
        await one.connected()
        await eventually(lambda: asked(one, "lift"))
        assert lift.is_held
        assert not later.done()
        await lift.release()
        assert (await asyncio.wait_for(later, 10.0)).is_held


async def test_the_log_tells_of_holds():
    async with pair() as (one, two):
        async with one.acquire("lift", "door"):
            pass
        await two.query_json("tca.unlock", {"name": "lift"})
        log = [line for line in await one.query(ReadLog()) if line.event.startswith("resource")]
        assert [line.event.split()[1] for line in log] == ["asked", "held", "released"]
        assert log[0].text == "lift, door by one"
