"""Killing (tca.md 3.7 and 4.2): what ends when, clean-ups, grace, and handlers that do not stop."""

from __future__ import annotations

import asyncio

import pytest
from tree_office import Office, only
from tree_robot import Fetch, Robot, Step, Stop

from tca_bus import (
    CleanUp,
    Command,
    KilledError,
    Module,
    TaskContext,
    TaskFailedError,
    TaskState,
    clean_up,
)
from tca_bus._attachments import Sending
from tca_bus._resource_messages import ListResources, ResourceStatus
from tca_bus.tasktree import Abandoned, Cancel, KillRequested, Suspended
from tca_bus.testing import eventually

CLEAN = CleanUp(id="u", sending=Sending(name="clean", task_class="goal"))


def test_what_was_not_begun_ends_at_once_and_what_runs_is_told_to_stop():
    office = Office()
    office.goal("A")
    office.command("a1", "A")
    office.command("a2", "A")
    effects = office.apply(KillRequested, "A", "enough")
    assert office.state("a2") is TaskState.KILLED
    assert {cancel.id: cancel.grace for cancel in only(effects, Cancel)} == {"A": 10.0, "a1": 10.0}
    assert not office.last["A"].is_ended


def test_a_kill_repeated_changes_nothing():
    office = Office()
    office.command("A")
    office.apply(KillRequested, "A", "enough")
    assert office.apply(KillRequested, "A", "more than enough") == []
    office.stop("A")
    assert office.last["A"].failure.text == "enough"


def test_a_handler_that_succeeds_all_the_same_has_been_killed():
    office = Office()
    office.command("A")
    office.apply(KillRequested, "A", "enough")
    office.done("A", result="too late")
    assert office.state("A") is TaskState.KILLED


def test_a_handler_that_does_not_stop_within_its_grace_is_waited_for_no_longer():
    office = Office(capacity=1)
    office.command("A", grace=0.5)
    office.command("B", flags=0)
    (stop,) = only(office.apply(KillRequested, "A", "enough"), Cancel)
    assert stop.grace == 0.5
    office.apply(Abandoned, "A", 1)
    assert office.state("A") is TaskState.KILLED
    assert not office.handling("B")
    office.done("A", attempt=1)
    assert office.handling("B")


def test_a_clean_up_delays_the_end_for_as_long_as_it_needs():
    office = Office()
    office.goal("A")
    office.command("a1", "A", attachments=[CLEAN])
    office.apply(KillRequested, "A", "enough")
    office.stop("A")
    assert not office.sent("clean")
    office.stop("a1")
    (clean,) = office.sent("clean")
    office.command("step", clean)
    office.done(clean)
    assert office.last["a1"].existence == office.last["A"].existence == "terminating"
    office.done("step")
    assert office.state("a1") is office.state("A") is TaskState.KILLED
    assert len(office.tree) == 0


def test_a_kill_spares_a_clean_up_unless_it_is_meant_itself():
    office = Office()
    office.command("A", attachments=[CLEAN])
    office.apply(KillRequested, "A", "enough")
    office.stop("A")
    (clean,) = office.sent("clean")
    office.apply(KillRequested, "A", "enough")
    assert office.handling(clean)
    office.apply(KillRequested, clean, "no time for that")
    office.stop(clean)
    assert office.state("A") is TaskState.KILLED


def test_a_clean_up_is_for_what_has_begun_and_was_not_achieved():
    office = Office()
    office.command("A", attachments=[CLEAN])
    office.command("B", attachments=[CLEAN])
    office.done("A")
    office.command("C", attachments=[CLEAN])
    office.apply(KillRequested, "C", "not begun")
    assert office.state("C") is TaskState.KILLED
    assert not office.sent("clean")
    office.fail("B")
    (clean,) = office.sent("clean")
    office.done(clean)
    assert office.state("B") is TaskState.FAILED


def test_a_clean_up_that_fails_lets_the_task_end_as_it_would():
    office = Office()
    office.command("A", attachments=[CLEAN])
    office.fail("A", "stuck")
    office.fail(office.sent("clean")[0], "dirty")
    assert office.state("A") is TaskState.FAILED
    assert office.last["A"].failure.name == "stuck"


def test_what_is_suspended_can_be_killed():
    office = Office()
    office.goal("A", attachments=[CLEAN])
    office.command("a1", "A")
    office.apply(Suspended, "A")
    office.apply(KillRequested, "A", "enough")
    office.stop("a1")
    office.stop("A")
    office.done(office.sent("clean")[0])
    assert office.state("A") is TaskState.KILLED


def test_a_kill_of_what_is_below_lets_the_task_take_new_children():
    office = Office()
    office.goal("A")
    office.command("a1", "A")
    office.apply(KillRequested, "A", "another way", only_below=True)
    office.stop("a1")
    office.command("a2", "A")
    office.done("A")
    office.done("a2")
    assert office.state("A") is TaskState.ACHIEVED


def test_a_prepared_place_is_let_go_by_a_kill():
    office = Office()
    office.goal("A")
    office.prepare("a1", parent="A")
    office.done("A")
    assert not office.last["A"].is_ended
    office.apply(KillRequested, "a1", "not needed")
    assert office.state("A") is TaskState.ACHIEVED


@pytest.mark.bus
async def test_a_clean_up_runs_when_a_task_is_killed_and_spares_one_that_succeeds(
    user: Module, robot: Robot
):
    fine = await user.execute(Step(name="a"), attach=[clean_up(Stop())])
    await fine.result(timeout=10.0)
    task = await user.execute(Step(name="wait"), attach=[clean_up(Stop())])
    await eventually(lambda: "wait" in robot.done)
    await task.kill("changed my mind")
    with pytest.raises(KilledError):
        await task.result(timeout=10.0)
    assert robot.done == ["a", "wait", "stop"]


@pytest.mark.bus
async def test_a_handler_that_does_not_stop_is_abandoned(user: Module, robot: Robot):
    class Stubborn(Command[None]):
        """Does not listen."""

        grace = 0.2

    async def stubborn(_: Stubborn, __: TaskContext) -> None:
        robot.done.append("stubborn")
        while not robot.hold.is_set():
            try:
                await robot.hold.wait()
            except asyncio.CancelledError:
                robot.done.append("ignored")

    robot.module.serve(Stubborn, stubborn)
    await user.wait_for(Stubborn, timeout=10.0)
    task = await user.execute(Stubborn())
    await eventually(lambda: "stubborn" in robot.done)
    await task.kill("enough")
    with pytest.raises(KilledError):
        await task.result(timeout=10.0)
    await eventually(lambda: robot.done == ["stubborn", "ignored"])
    place = await stubborn_place(user)
    assert [(one.id, one.waiting_for) for one in place.holders] == [
        (task.id, "its handler to stop")
    ]
    robot.hold.set()
    await eventually(lambda: is_free(user))


async def stubborn_place(user: Module) -> ResourceStatus:
    listed = await user.query(ListResources())
    return next(one for one in listed if one.name == "robot/stubborn")


async def is_free(user: Module) -> bool:
    return not (await stubborn_place(user)).holders


@pytest.mark.bus
async def test_a_kill_reaches_what_is_below_and_its_sender(user: Module, robot: Robot):
    task = await user.expand(Fetch(what="wait+b"))
    await eventually(lambda: "wait" in robot.done)
    step = await user.relative(task, "first_child")
    await user.kill(task.id, reason="changed my mind")
    with pytest.raises(KilledError, match="changed my mind"):
        await task.result(timeout=10.0)
    assert step is not None
    assert robot.done == ["wait"]


@pytest.mark.bus
async def test_a_kill_of_what_is_below_spares_the_task(user: Module, robot: Robot):
    task = await user.expand(Fetch(what="wait+b"))
    await eventually(lambda: "wait" in robot.done)
    await user.kill(task.id, reason="another way", only_below=True)
    assert await task.result(timeout=10.0) == "wait+b"


@pytest.mark.bus
async def test_a_clean_up_runs_when_a_task_fails(user: Module, robot: Robot):
    task = await user.execute(Step(name="a", fails=True), attach=[clean_up(Stop())])
    with pytest.raises(TaskFailedError):
        await task.result(timeout=10.0)
    assert robot.done == ["a", "stop"]
