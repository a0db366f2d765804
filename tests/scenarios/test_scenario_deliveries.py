"""An office with several users, a closed door, and processes that are killed."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator

import pytest
import pytest_asyncio
from office_kit import Office, office

from rogue.messages import CancelRequest
from tca_bus.testing import eventually
from xavier_sim.messages import MoveDoor, WhereReally

pytestmark = [
    pytest.mark.scenario,
    pytest.mark.process,
    pytest.mark.timeout(180),
    pytest.mark.asyncio(loop_scope="module"),
]

USERS = [
    ("delivermail", "mitchell"),
    ("deliverfax", "jhm"),
    ("deliverfax", "veloso"),
]


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def running(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[Office]:
    async with office(tmp_path_factory.mktemp("office"), later=0.5) as running:
        yield running


async def outcome(process: asyncio.subprocess.Process) -> tuple[int, str]:
    out, err = await process.communicate()
    return process.returncode or 0, out.decode() + err.decode()


async def test_three_users_one_after_the_other(running: Office):
    for item, user in USERS:
        code, said = await outcome(await running.request(item, user))
        assert code == 0, said
        assert said.rstrip().endswith("completed")


async def test_three_users_all_at_once(running: Office):
    waiting = [await running.request(item, user) for item, user in USERS]
    for code, said in await asyncio.gather(*map(outcome, waiting)):
        assert code == 0, said


async def test_what_scripts_read_has_its_shape(running: Office):
    found = await running.requests()
    fields = "id user item pickup deliver state rank posted deadline finished reason"
    assert all(set(fields.split()) <= set(one) for one in found)
    code, out, err = await running.command("tca_bus", "modules", "--json")
    assert code == 0, err
    modules = {one["name"]: one for one in json.loads(out)}
    assert {"central", "xavier", "speech", "navigate", "rogue"} <= set(modules)
    assert {"name", "pid", "host", "state", "provides"} <= set(modules["rogue"])


async def test_a_delivery_door_that_stays_closed_is_the_reason(running: Office):
    await running.module.query(MoveDoor(room="r-5317", open=False))
    words = ("--from", "r-5313", "--to", "r-5317", "--deadline", "30m")
    code, said = await outcome(await running.request("delivermail", "simmons", *words))
    await running.module.query(MoveDoor(room="r-5317", open=True))
    assert code == 1
    assert "cannot get to r-5317, door_blocked" in said
    assert "the item is back in r-5313" in said


async def test_a_delivery_door_that_is_opened_in_time_lets_it_complete(running: Office):
    await running.module.query(MoveDoor(room="r-5311", open=False))
    after = running.last
    words = ("--from", "r-5315", "--to", "r-5311")
    process = await running.request("delivermail", "pstone", *words)
    await running.line(lambda text: "trying again after" in text, after=after)
    await running.module.query(MoveDoor(room="r-5311", open=True))
    code, said = await outcome(process)
    assert code == 0, said


async def test_a_request_is_canceled_while_it_is_driven_for(running: Office):
    after = running.last
    process = await running.request("delivermail", "mperez", "--id", "unwanted")
    await running.line(lambda text: "TCAEXPANDGOAL" in text, after=after)
    # Not by a command: in lockstep the errand may be done before that has started.
    order = CancelRequest(id="unwanted", reason="canceled by its user")
    assert (await running.module.query(order)).id == "unwanted"
    code, said = await outcome(process)
    assert code == 6
    assert "canceled by its user" in said
    await running.line(lambda text: text.startswith("Listening"), after=after)


@pytest.mark.parametrize("victim", ["navigate", "speech", "xavier", "rogue", "central", "router"])
async def test_a_killed_process_costs_no_request(running: Office, victim: str):
    after, before = running.last, len(running.moved)
    words = ("--from", "r-5307", "--deadline", "6h")
    process = await running.request("delivermail", "mitchell", *words)
    acquired = await running.line(lambda text: "(ACQUIRE-ITEM 1" in text, after=after)
    sent = await running.line(lambda text: "TCAEXPANDGOAL" in text, after=acquired.seq)
    start = (await running.module.query(WhereReally())).metres

    async def drives() -> bool:
        return (await running.module.query(WhereReally())).metres > start + 0.5

    await eventually(drives, what="the robot to drive")
    restarts = running.launcher.restarts(victim)
    assert not any("finished." in line.text for line in running.lines if line.seq > sent.seq)
    running.kill(victim)
    await running.launcher.wait_restarted(victim, beyond=restarts)
    code, said = await outcome(process)
    assert code == 0, said
    lines = [line.text for line in running.lines if line.seq > after]
    assert sum("finished placing" in line for line in lines) == 1
    placed = [one for one in running.moved[before:] if one.action == "placed"]
    assert len(placed) == 1
