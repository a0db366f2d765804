"""Monitors (tca.md 3.9): point, polling and demon; counts, spans, and their place in the tree."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from tree_office import Office
from tree_robot import Charge, Low, Robot, Step, Watch

from tca_bus import Demon, Goal, Module, MonitorContext, Query, TaskContext, TaskState
from tca_bus._attachments import Sending
from tca_bus._monitor_spec import MonitorSpec
from tca_bus._orders import TaskRef
from tca_bus._time_messages import AwaitTime
from tca_bus.tasktree import Cancel, KillRequested, ProviderLost, Submitted, Triggered
from tca_bus.testing import TimeSource, bus, central

ACTION = Sending(name="command", task_class="command", data={"volts": 0.0, "why": "low"})


def watch(office: Office, id: str, parent: str | None, kind: Any = "polling", **facts: Any) -> Any:
    spec = MonitorSpec(kind=kind, action=ACTION, **facts)
    policy = {"on_module_lost": "resend"}
    return office.submit(id, "monitor", parent, 0, name="watch", monitor=spec, **policy)


def trigger(office: Office, id: str, number: int, **data: Any) -> Any:
    return office.apply(Triggered, id, office.last[id].attempt, number, data)


def actions(office: Office) -> list[dict[str, Any]]:
    made = [event for event in office.records if isinstance(event, Submitted)]
    return [event.task.data for event in made if event.origin.role == "action"]


def finish_actions(office: Office) -> None:
    for id in office.sent("command"):
        office.done(id)


def counts(office: Office, id: str) -> tuple[int, int]:
    result = office.last[id].result
    return result["satisfied"], result["fired"]


def test_an_action_is_a_child_of_its_monitor_and_has_the_condition_s_data():
    office = Office()
    office.goal("A")
    watch(office, "m", "A")
    trigger(office, "m", 1, volts=10.5, unknown=True)
    (action,) = office.sent("command")
    assert office.tree.status(action).parent == "m"
    assert actions(office) == [{"volts": 10.5, "why": "low"}]


def test_each_nth_test_fires_and_at_most_so_often():
    office = Office()
    office.goal("A")
    watch(office, "m", "A", "demon", fire_every=3, max_fire=2)
    for number in range(1, 7):
        assert len(actions(office)) == (number - 1) // 3
        trigger(office, "m", number)
    office.done("m")
    finish_actions(office)
    assert counts(office, "m") == (6, 2)
    assert office.state("m") is TaskState.ACHIEVED


def test_a_test_that_is_told_twice_counts_once():
    office = Office()
    office.goal("A")
    watch(office, "m", "A")
    trigger(office, "m", 1)
    assert trigger(office, "m", 1) == []
    assert len(actions(office)) == 1


def test_a_monitor_expires_when_its_parent_has_nothing_else_to_do():
    office = Office()
    office.goal("A")
    watch(office, "m", "A")
    office.command("a1", "A")
    office.done("A")
    assert office.handling("m")
    effects = office.done("a1")
    assert [cancel.id for cancel in effects if isinstance(cancel, Cancel)] == ["m"]
    assert not office.last["A"].is_ended
    office.stop("m")
    assert office.state("m") is office.state("A") is TaskState.ACHIEVED


def test_what_a_monitor_began_goes_on_when_it_expires():
    office = Office()
    office.goal("A")
    watch(office, "m", "A")
    trigger(office, "m", 1)
    office.done("A")
    assert office.handling("m")
    finish_actions(office)
    office.stop("m")
    assert office.state("A") is TaskState.ACHIEVED


@pytest.mark.parametrize("end", ["done", "fail", "kill"])
def test_a_monitor_expires_at_the_point_that_it_is_told(end):
    office = Office()
    office.command("B", sender="you")
    watch(office, "m", None, until=TaskRef("B").achieving.end.ref)
    office.done("B") if end == "done" else office.fail("B") if end == "fail" else None
    if end == "kill":
        office.apply(KillRequested, "B", "enough")
        office.stop("B")
    assert office.tree.node("m").watch.expired
    office.stop("m")
    assert office.state("m") is TaskState.ACHIEVED


def test_a_monitor_begins_at_the_point_that_it_is_told():
    office = Office()
    office.goal("A")
    office.command("a1", "A", 0)
    office.command("a2", "A", 1)
    spec = MonitorSpec(kind="polling", action=ACTION)
    begin = TaskRef("a2").achieving.start <= TaskRef("m").achieving.start
    office.submit("m", "monitor", "A", 0, name="watch", monitor=spec, orders=[begin])
    assert office.state("m") is TaskState.INACTIVE
    office.done("a1")
    assert office.handling("m")


def test_a_monitor_is_no_previous_sibling_but_a_point_monitor_is():
    office = Office()
    office.goal("A")
    watch(office, "m", "A")
    office.command("a1", "A")
    assert office.handling("a1")
    office.done("a1")
    watch(office, "p", "A", "point")
    office.command("a2", "A")
    assert office.state("a2") is TaskState.INACTIVE
    office.done("p", result={"satisfied": False})
    assert office.handling("a2")


def test_a_point_monitor_that_holds_lasts_until_its_action_is_done():
    office = Office()
    office.goal("A")
    watch(office, "p", "A", "point")
    office.command("a1", "A")
    office.done("p", result={"satisfied": True, "data": {"volts": 9.0}})
    assert actions(office) == [{"volts": 9.0, "why": "low"}]
    assert office.state("a1") is TaskState.INACTIVE
    finish_actions(office)
    assert counts(office, "p") == (1, 1)
    assert office.handling("a1")


def test_an_action_that_fails_fails_its_monitor_and_so_its_parent():
    office = Office()
    office.goal("A")
    watch(office, "m", "A")
    office.command("a1", "A")
    trigger(office, "m", 1)
    office.done("A")
    effects = office.fail(office.sent("command")[0], "no_charger")
    assert [cancel.id for cancel in effects if isinstance(cancel, Cancel)] == ["m"]
    office.stop("m")
    office.stop("a1")
    assert office.state("A") is TaskState.FAILED
    names = [link.name for link in office.last["A"].failure.chain()]
    assert names == ["child_failed", "child_failed", "no_charger"]


def test_a_monitor_whose_module_dies_goes_on_elsewhere_with_its_counts():
    office = Office()
    office.goal("A")
    office.done("A")
    watch_at_root(office)
    trigger(office, "m", 1)
    trigger(office, "m", 2)
    office.appear("other", "o1")
    office.apply(ProviderLost, office.tree.node("m").incarnation)
    finish_actions(office)
    for id in office.sent("command"):
        office.stop(id)
    assert office.last["m"].attempt == 2
    trigger(office, "m", 1)
    watched = office.tree.node("m").watch
    assert (watched.satisfied, watched.fired) == (3, 3)


def watch_at_root(office: Office) -> None:
    watch(office, "m", None)


@pytest.mark.bus
async def test_a_polling_monitor_acts_while_its_parent_is_under_way(user: Module, robot: Robot):
    class Patrol(Goal[int]):
        """Walk until told, watching the battery."""

    async def patrol(_: Patrol, ctx: TaskContext) -> int:
        watch = await ctx.monitor(Low(limit=11.0), then=Charge(volts=1.0), every=0.01, most=2)
        robot.volts = 10.5
        report = await watch.result(timeout=10.0)
        await ctx.monitor(Low(limit=1.0), then=Charge(), every=0.01)
        return report.fired

    robot.module.serve(Patrol, patrol)
    await user.wait_for(Patrol, timeout=10.0)
    assert await (await user.expand(Patrol())).result(timeout=10.0) == 2
    assert robot.done == ["charge 10.5"] * 2


@pytest.mark.bus
async def test_a_point_monitor_tests_once_at_its_place(user: Module, robot: Robot):
    class Trip(Goal[None]):
        """A step, a test, a step."""

    async def trip(_: Trip, ctx: TaskContext) -> None:
        await ctx.execute(Step(name="a"))
        await ctx.test(Low(limit=20.0), then=Charge(volts=1.0))
        await ctx.test(Low(limit=1.0), then=Charge(volts=1.0))
        await ctx.execute(Step(name="b"))

    robot.module.serve(Trip, trip)
    await user.wait_for(Trip, timeout=10.0)
    await (await user.expand(Trip())).result(timeout=10.0)
    assert robot.done == ["a", "charge 12", "b"]


@pytest.mark.bus
async def test_a_demon_fires_each_nth_time_and_at_most_so_often(user: Module, robot: Robot):
    watch = await user.monitor(Watch(door="r-5313"), then=Charge(volts=2.0), fire_every=2, most=2)
    report = await watch.result(timeout=10.0)
    assert (report.satisfied, report.fired) == (4, 2)
    assert robot.done.count("charge 1") == 2
    assert robot.done.count("saw r-5313") == 3


class Idle(Demon):
    """Watches without end and never fires."""


async def idle(_: Idle, __: MonitorContext) -> None:
    await asyncio.Event().wait()


@pytest.mark.bus
async def test_the_time_that_a_monitor_lasts_and_waits_is_on_the_clock():
    async with (
        bus(clock="sim") as options,
        central(options),
        Module("user", options=options) as user,
        Module("robot", options=options) as module,
        user.subscribe(AwaitTime) as waits,
    ):
        Robot(module).serve()
        module.serve(Idle, idle)
        source = TimeSource(user, start=100.0)
        await source.tell()
        await module.clock.wait_ready(10.0)
        await user.wait_for(Low, Idle, "tca.submit", timeout=10.0)

        async def goes_to(time: float) -> None:
            """Let it be the time for which the robot waits."""
            async for wait in waits:
                if (wait.module, wait.until) == ("robot", time):
                    break
            await source.advance(time - source.now)

        watch = await user.monitor(
            Low(limit=20.0), then=Charge(), every=5.0, first_wait=10.0, duration=12.0
        )
        for time in (110.0, 115.0, 120.0, 122.0):
            assert not watch.status.is_ended
            await goes_to(time)
        report = await watch.result(timeout=10.0)
        assert report.satisfied == report.fired == 3
        demon = await user.monitor(Idle(), then=Charge(), duration=7.0)
        await goes_to(129.0)
        assert (await demon.result(timeout=10.0)).fired == 0


@pytest.mark.bus
async def test_a_condition_may_be_a_plain_truth(user: Module, robot: Robot):
    class Dark(Query[bool]):
        """Whether it is dark."""

    async def dark(_: Dark, __: Any) -> bool:
        return True

    robot.module.serve(Dark, dark)
    await user.wait_for(Dark, timeout=10.0)
    test = await user.test(Dark(), then=Charge(volts=3.0))
    assert (await test.result(timeout=10.0)).fired == 1
    assert robot.done == ["charge 3"]
