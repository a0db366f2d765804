"""``tca resources``, ``reserve``, ``lock`` and ``unlock`` as their users have them."""

from __future__ import annotations

import asyncio

import pytest
from central_robot import Quick
from test_tca_cli import office

from tca_bus import LeaseLostError
from tca_bus._resource_messages import ListResources
from tca_bus.testing import eventually

pytestmark = pytest.mark.bus


async def known(here, name):
    async def is_listed():
        listed = await here.me.query(ListResources())
        return any(status.name == name for status in listed)

    await eventually(is_listed)


async def test_who_holds_and_who_waits_is_listed():
    async with office() as here:
        await known(here, "robot/quick")
        async with here.me.acquire("lift", "door"):
            listed, table = await here.tca("resources", "--json"), await here.tca("resources")
        by_name = {status["name"]: status for status in listed.json}
        assert list(by_name)[:2] == ["door", "lift"]
        assert {"name", "kind", "capacity", "holders", "waiters", "dropped", "cycles"} <= set(
            by_name["lift"]
        )
        assert [user["module"] for user in by_name["lift"]["holders"]] == ["me"]
        assert by_name["robot/quick"]["capacity"] == 8
        assert "me (lease) since" in table.out


async def test_a_lock_by_hand_lasts_until_it_is_unlocked_by_hand():
    async with office() as here:
        await known(here, "robot/quick")
        locked = await here.tca("lock", "quick")
        assert locked.code == 0
        assert "'tca unlock robot/quick' ends it" in locked.out
        task = await here.me.execute(Quick(number=3))
        assert task.status.waiting_for.endswith("who has a lock")
        unlocked = await here.tca("unlock", "robot/quick")
        assert "the lock of robot/quick by tca-" in unlocked.out
        assert await task.result(timeout=10.0) == 3
        assert "nobody holds" in (await here.tca("unlock", "robot/quick")).err


async def test_a_reservation_by_hand_is_for_one_module():
    async with office() as here:
        await known(here, "robot/quick")
        reserved = await here.tca("reserve", "robot/quick", "--for", "me", "--json")
        assert (reserved.json["kind"], reserved.json["passes"]) == ("reservation", "me")
        task = await here.me.execute(Quick(number=3))
        assert await task.result(timeout=10.0) == 3
        refused = await here.tca("command", "quick", '{"number": 1}', "--timeout", "1")
        assert refused.code == 4


async def test_a_lease_is_taken_away_by_hand():
    async with office() as here:
        lease = await here.me.acquire("lift")
        ended = await here.tca("unlock", "lift", "--json")
        assert [status["module"] for status in ended.json] == ["me"]
        assert isinstance(await lease.lost(), LeaseLostError)


async def test_a_lock_that_does_not_begin_in_time_is_withdrawn():
    async with office() as here, here.me.acquire("lift"):
        late = await here.tca("lock", "lift", "--timeout", "0.5")
        assert late.code == 4
        assert "waits for lift, which me has" in late.err
        listed = await here.me.query(ListResources())
        assert [user.kind for user in listed[0].holders] == ["lease"]
        assert listed[0].waiters == []


async def test_a_waiting_lock_begins_when_the_lease_ends():
    async with office() as here:
        lease = await here.me.acquire("lift")
        locking = asyncio.create_task(here.tca("lock", "lift"), name="locking")

        async def waits():
            return (await here.me.query(ListResources()))[0].waiters

        await eventually(waits)
        await lease.release()
        assert (await locking).code == 0


async def test_an_unknown_handlers_resource_is_refused_with_what_looks_like_it():
    async with office() as here:
        await known(here, "robot/quick")
        refused = await here.tca("lock", "robot/quik")
        assert refused.code == 7
        assert "'robot/quick'" in refused.err
        wrong = await here.tca("lock", "no such name")
        assert wrong.code == 2
