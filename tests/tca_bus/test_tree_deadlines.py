"""Deadlines (tca.md 8): a task that is not achieved in time fails by name."""

from __future__ import annotations

import pytest
from tree_office import Office
from tree_robot import Robot, Step

from tca_bus import Catch, Module, TaskFailedError, TaskState
from tca_bus.tasktree import Abandoned, Tree


def test_a_running_handler_is_stopped_and_then_the_task_has_failed():
    office = Office()
    office.command("A", within=5.0)
    assert office.wake() == 7.0
    assert not office.last["A"].is_ended
    office.stop("A")
    assert office.state("A") is TaskState.FAILED
    assert office.last["A"].failure.name == "deadline_passed"


def test_one_that_waits_fails_at_once():
    office = Office(capacity=0)
    office.command("A", within=5.0)
    office.wake()
    assert office.last["A"].failure.name == "deadline_passed"


def test_what_is_below_it_ends_with_it():
    office = Office()
    office.goal("A", within=5.0)
    office.command("a1", "A")
    office.done("A")
    office.wake()
    office.stop("a1")
    assert office.state("a1") is TaskState.KILLED
    assert office.state("A") is TaskState.FAILED


def test_a_deadline_is_an_exception_that_a_handler_may_take():
    office = Office()
    office.goal("A", attachments=[Catch(id="c", exception="deadline_passed", handler="fix")])
    office.command("a1", "A", within=5.0)
    office.wake()
    office.stop("a1")
    office.done(office.sent("fix")[0], result="it was not so urgent")
    assert office.state("a1") is TaskState.ACHIEVED


def test_what_is_achieved_in_time_is_left_alone():
    office = Office()
    office.command("A", within=5.0)
    office.done("A")
    assert office.state("A") is TaskState.ACHIEVED
    assert not office.tree.is_awaited("A", "deadline")


def test_a_handler_that_does_not_stop_does_not_delay_the_failure():
    office = Office()
    office.command("A", within=5.0)
    office.wake()
    office.apply(Abandoned, "A", 1)
    assert office.last["A"].failure.name == "deadline_passed"


def test_a_deadline_holds_over_a_restart():
    office = Office()
    office.command("A", within=5.0)
    tree = Tree(generation=1)
    tree.replay(office.records)
    assert tree.is_awaited("A", "deadline")


@pytest.mark.bus
async def test_a_deadline_fails_a_task_by_name(user: Module, robot: Robot):
    task = await user.execute(Step(name="wait"), within=0.1)
    with pytest.raises(TaskFailedError, match=r"not achieved within 0\.1 s") as failed:
        await task.result(timeout=10.0)
    assert failed.value.failure.name == "deadline_passed"
