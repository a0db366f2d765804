"""Resources on a real bus: leases, locks and reservations, grouped handlers, and their ends."""

from __future__ import annotations

import asyncio
import logging
import signal
import sys
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from resource_holder import Ride

from tca_bus import (
    BusOptions,
    Command,
    ConfigError,
    DeadlockError,
    Goal,
    Inform,
    InvalidMessageError,
    LeaseLostError,
    Module,
    PendingLimitError,
    Query,
    RefusedError,
    Router,
    TaskFailedError,
    TimedOutError,
)
from tca_bus._protocol import ReadLog
from tca_bus._resource_messages import ListResources, UnlockResource
from tca_bus.testing import bus, central, eventually

pytestmark = pytest.mark.bus

HOLDER = str(Path(__file__).with_name("resource_holder.py"))


class Grasp(Command[str]):
    """Ends when the gate of the arm opens."""


class Wave(Command[str]):
    """As `Grasp`."""


class Nested(Command[str]):
    """Awaits one of itself below it."""

    depth: int


class Touch(Query[int]):
    """How many are in the arm."""


class Nudge(Inform):
    """Enters the arm."""


class Trip(Goal[None]):
    """Keeps a thing until all below it has ended."""

    thing: str


@asynccontextmanager
async def pair(*, data=None):
    """A bus with central and two modules."""
    async with (
        bus() as options,
        central(options, data=data),
        Module("one", options=options) as one,
        Module("two", options=options) as two,
    ):
        await one.wait_for("tca.acquire", timeout=5.0)
        await two.wait_for("tca.acquire", timeout=5.0)
        yield one, two


async def resource(module, name):
    listed = await module.query(ListResources())
    return next((status for status in listed if status.name == name), None)


async def holders(module, name):
    status = await resource(module, name)
    return [user.module for user in status.holders] if status else []


async def waiters(module, name):
    status = await resource(module, name)
    return [user.module for user in status.waiters] if status else []


def waiting(module, *names, **options):
    """Ask in a task of its own."""

    async def take():
        return await module.acquire(*names, **options)

    return asyncio.ensure_future(take())


async def test_a_thing_is_held_by_one_at_a_time():
    async with pair() as (one, two):
        async with one.acquire("lift") as lease:
            assert lease.is_held
            later = waiting(two, "lift")
            await eventually(lambda: waiters(one, "lift"))
            assert await holders(one, "lift") == ["one"]
        assert not lease.is_held
        theirs = await asyncio.wait_for(later, 5.0)
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
        lease = await asyncio.wait_for(both, 5.0)
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
            await asyncio.wait_for(first, 5.0)
        assert (await resource(one, "chargers")).dropped == 1
        await held[0].release()
        assert (await asyncio.wait_for(second, 5.0)).is_held
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
        assert (await asyncio.wait_for(inner, 5.0)).is_held
        await theirs.release()
        assert (await asyncio.wait_for(later, 5.0)).is_held


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
            await asyncio.wait_for(riding, 5.0)
        assert after == []
        assert riding.cancelling() == 0
        assert await resource(one, "lift") is None


async def test_a_kept_lease_says_when_it_is_lost():
    async with pair() as (one, two):
        lease = await one.acquire("lift")
        lost = asyncio.ensure_future(lease.lost())
        await two.query(UnlockResource(name="lift"))
        assert "unlocked by two" in str(await asyncio.wait_for(lost, 5.0))
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


@asynccontextmanager
async def holder(options, *names):
    process = await asyncio.create_subprocess_exec(
        sys.executable, HOLDER, options.connect, options.realm, *names
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            process.kill()
        await process.wait()


@pytest.mark.process
async def test_a_killed_process_holds_nothing():
    async with pair() as (one, two), holder(one.options, "lift", "door") as process:
        await eventually(lambda: holders(one, "lift"), timeout=20.0)
        later = waiting(two, "door")
        await eventually(lambda: waiters(one, "door"))
        process.send_signal(signal.SIGKILL)
        assert (await asyncio.wait_for(later, 10.0)).is_held
        assert await resource(one, "lift") is None


@pytest.mark.process
async def test_a_killed_handler_holds_nothing():
    async with pair() as (one, two), holder(one.options) as process:
        await one.wait_for(Ride, timeout=20.0)
        task = await one.execute(Ride(thing="lift"))
        await eventually(lambda: holders(one, "lift"))
        later = waiting(two, "lift")
        await eventually(lambda: waiters(one, "lift"))
        process.send_signal(signal.SIGKILL)
        assert (await asyncio.wait_for(later, 10.0)).is_held
        with pytest.raises(TaskFailedError, match="module_lost"):
            await task.result(timeout=5.0)


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
            await eventually(lambda: _asked(one, "lift"))
            assert await holders(one, "lift") == ["one"]
            assert await waiters(one, "lift") == ["two"]
            assert (await resource(one, "chargers")).capacity == 3
            await lift.release()
            assert (await asyncio.wait_for(later, 10.0)).is_held


async def _asked(module, name):
    try:
        return await resource(module, name)
    except Exception:  # central is not there yet
        return None


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
    router = Router("tcp/127.0.0.1:0")
    await router.__aenter__()
    options = BusOptions(connect=router.endpoint, realm="leases")
    try:
        async with (
            central(options),
            Module("one", options=options) as one,
            Module("two", options=options) as two,
        ):
            lift = await one.acquire("lift")
            later = waiting(two, "lift")
            await eventually(lambda: waiters(one, "lift"))
            await router.__aexit__(None, None, None)
            await eventually(lambda: not one.is_connected)
            router = Router(options.connect)
            await router.__aenter__()
            await one.connected()
            await eventually(lambda: _asked(one, "lift"))
            assert lift.is_held
            assert not later.done()
            await lift.release()
            assert (await asyncio.wait_for(later, 10.0)).is_held
    finally:
        await router.__aexit__(None, None, None)


async def test_the_log_tells_of_holds():
    async with pair() as (one, two):
        async with one.acquire("lift", "door"):
            pass
        await two.query_json("tca.unlock", {"name": "lift"})
        log = [line for line in await one.query(ReadLog()) if line.event.startswith("resource")]
        assert [line.event.split()[1] for line in log] == ["asked", "held", "released"]
        assert log[0].text == "lift, door by one"


class Arm:
    """A module whose handlers share an arm."""

    def __init__(self, options, *, name="robot", capacity=1, pending=None):
        self.module = module = Module(name, options=options)
        self.open = asyncio.Event()
        self.inside = 0
        self.most = 0
        self.nudged = 0
        module.resource("arm", capacity=capacity, pending=pending)
        module.serve(Grasp, self.use, resource="arm")
        module.serve(Wave, self.use, resource="arm")
        module.serve(Touch, self.touch, resource="arm")
        module.serve(Nudge, self.nudge, resource="arm")
        module.serve(Nested, self.nested)
        module.serve(Trip, self.trip)

    async def use(self, _message, _context):
        self.inside += 1
        self.most = max(self.most, self.inside)
        try:
            await self.open.wait()
        finally:
            self.inside -= 1
        return "done"

    async def touch(self, _message, _context):
        return self.inside

    async def nudge(self, _message, _context):
        self.nudged += 1

    async def nested(self, message, context):
        if message.depth:
            below = await context.execute(Nested(depth=message.depth - 1))
            return await below.result()
        return "bottom"

    async def trip(self, message, context):
        await context.acquire(message.thing)
        await context.execute(Grasp())


@asynccontextmanager
async def armed(**facts):
    async with pair() as (one, two):
        arm = Arm(one.options, **facts)
        async with arm.module:
            await eventually(lambda: resource(one, "robot/arm"))
            yield one, two, arm
            arm.open.set()


async def test_handlers_in_one_resource_exclude_each_other():
    async with armed() as (one, two, arm):
        tasks = [
            await one.execute(Grasp()),
            await two.execute(Wave()),
            await one.execute(Grasp(), constraints=0),
        ]
        await eventually(lambda: arm.inside == 1)
        listed = await resource(one, "robot/arm")
        assert listed.messages == ("grasp", "wave")
        assert len(listed.holders) == 1
        assert len(listed.waiters) == 2
        assert listed.waiters[0].waiting_for == "robot, which has 1 in its resource 'arm'"
        arm.open.set()
        assert [await task.result(timeout=5.0) for task in tasks] == ["done"] * 3
        assert arm.most == 1


async def test_queries_and_informs_take_their_turn_in_a_resource():
    async with armed() as (one, two, arm):
        await one.execute(Grasp())
        await eventually(lambda: arm.inside == 1)
        asked = asyncio.ensure_future(two.query(Touch()))
        await one.inform(Nudge())
        assert await arm.module.query(Touch()) == 1
        assert not asked.done()
        assert arm.nudged == 0
        arm.open.set()
        assert await asyncio.wait_for(asked, 5.0) == 0
        await eventually(lambda: arm.nudged == 1)


async def test_of_too_many_tasks_the_oldest_fails():
    async with armed(pending=1) as (one, two, arm):
        await one.execute(Grasp())
        await eventually(lambda: arm.inside == 1)
        first = await two.execute(Wave())
        second = await one.execute(Wave(), constraints=0)
        with pytest.raises(TaskFailedError) as caught:
            await first.result(timeout=5.0)
        assert caught.value.failure.name == "pending_limit"
        assert caught.value.failure.data == {"resource": "robot/arm", "limit": 1}
        assert (await resource(one, "robot/arm")).dropped == 1
        arm.open.set()
        assert await second.result(timeout=5.0) == "done"


async def test_a_lock_waits_for_handlers_and_keeps_others_out():
    async with armed() as (one, two, arm):
        running = await one.execute(Grasp())
        await eventually(lambda: arm.inside == 1)

        async def take():
            return await two.lock("arm")

        locking = asyncio.ensure_future(take())
        await eventually(lambda: waiters(one, "robot/arm"))
        later = await one.execute(Wave(), constraints=0)
        arm.open.set()
        assert await running.result(timeout=5.0) == "done"
        lock = await asyncio.wait_for(locking, 5.0)
        assert lock.names == ("arm",)
        status = await resource(one, "robot/arm")
        assert [user.kind for user in status.holders] == ["lock"]
        assert status.waiters[0].waiting_for == "robot, which is held by two, who has a lock"
        assert later.status.state == "pending"
        await lock.release()
        assert await later.result(timeout=5.0) == "done"


async def test_a_reservation_passes_the_reservers_messages_only():
    async with armed() as (one, two, arm):
        arm.open.set()
        async with one.reserve("robot/arm"):
            mine = await one.execute(Grasp())
            assert await mine.result(timeout=5.0) == "done"
            theirs = await two.execute(Grasp())
            with pytest.raises(TimedOutError):
                await theirs.result(timeout=0.3)
            with pytest.raises(RefusedError, match="has a reservation of it already"):
                await one.reserve("robot/arm")
        assert await theirs.result(timeout=5.0) == "done"


async def test_a_lock_outlives_central_and_ends_with_its_module(tmp_path):
    async with bus() as options, Module("two", options=options) as two:
        arm = Arm(options)
        arm.open.set()
        async with arm.module, Module("one", options=options) as one:
            async with central(options, data=tmp_path):
                await eventually(lambda: _asked(two, "robot/arm"))
                await one.lock("robot/")
            async with central(options, data=tmp_path):
                await eventually(lambda: _asked(two, "robot/arm"))
                assert await holders(two, "robot/") == ["one"]
                task = await two.execute(Grasp())
                assert task.status.state == "pending"
                await one.__aexit__(None, None, None)
                assert await task.result(timeout=10.0) == "done"


async def test_a_lock_of_what_nobody_has_is_refused():
    async with armed() as (one, _two, _arm):
        with pytest.raises(RefusedError, match=r"Did you mean 'robot/arm'"):
            await one.lock("robot/arn")
        with pytest.raises(RefusedError, match="reserve or lock it instead"):
            await one.acquire("robot/arm")
        with pytest.raises(InvalidMessageError, match="names"):
            await one.acquire("no such name")


async def test_a_short_name_that_several_have_is_refused():
    async with armed() as (one, _two, _arm), Arm(one.options, name="other").module:
        await eventually(lambda: resource(one, "other/arm"))
        with pytest.raises(RefusedError, match="several: other/arm, robot/arm"):
            await one.lock("arm")


async def test_a_lease_kept_by_a_goal_lasts_until_all_below_it_has_ended():
    async with armed() as (one, two, arm):
        trip = await one.expand(Trip(thing="lift"))
        await eventually(lambda: arm.inside == 1)
        later = waiting(two, "lift")
        await eventually(lambda: waiters(one, "lift"))
        (user,) = (await resource(one, "lift")).holders
        assert user.task == trip.id
        arm.open.set()
        await trip.result(timeout=5.0)
        assert (await asyncio.wait_for(later, 5.0)).is_held


async def test_a_handler_that_awaits_one_of_itself_is_reported(caplog):
    async with armed() as (one, _two, _arm):
        caplog.set_level(logging.WARNING)
        task = await one.execute(Nested(depth=1))

        async def rings():
            return (await resource(one, "robot/nested")).cycles

        await eventually(rings)
        (ring,) = await rings()
        assert task.id in ring
        assert caplog.text.count("wait for each other for ever") == 1
        await task.kill("it would never end")


async def test_resources_of_a_module_are_checked_where_they_are_made():
    module = Module("robot")
    module.resource("arm", capacity=2)
    with pytest.raises(ConfigError, match="has not given yet"):
        module.resource("arm")
    with pytest.raises(ConfigError, match="at least 1"):
        module.resource("leg", capacity=0)
    with pytest.raises(ConfigError, match="Did you mean 'arm'"):
        module.serve(Grasp, _noop, resource="arn")
    with pytest.raises(ConfigError, match="none for a handler in resource 'arm'"):
        module.serve(Grasp, _noop, resource="arm", capacity=3)
    with pytest.raises(ConfigError, match="no goal or command"):
        module.serve(Touch, _noop, pending=3)


async def _noop(_message, _context):
    return None
