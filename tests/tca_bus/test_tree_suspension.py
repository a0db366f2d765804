"""Suspending and resuming (tca.md 4.2): what waits, what goes on, and what comes later."""

from __future__ import annotations

import pytest
from tree_office import Office
from tree_robot import Fetch, Robot

from tca_bus import CleanUp, Module
from tca_bus._attachments import Sending
from tca_bus.tasktree import KillRequested, Resumed, Suspended, Tree
from tca_bus.testing import eventually

CLEAN = CleanUp(id="u", sending=Sending(name="clean", task_class="command"))


def test_nothing_at_or_below_it_begins_and_what_runs_goes_on():
    office = Office()
    office.goal("A")
    office.goal("B", "A")
    office.command("b1", "B")
    office.command("b2", "B")
    office.apply(Suspended, "A")
    assert office.handling("A", "B", "b1")
    office.done("b1")
    assert not office.handling("b2")
    assert office.tree.status("b2").waiting_for == "being resumed"
    assert all(status.suspended for status in office.tree.statuses())
    office.apply(Resumed, "A")
    assert office.handling("b2")
    assert not any(status.suspended for status in office.tree.statuses())


def test_what_is_sent_below_it_is_suspended_too():
    office = Office()
    office.goal("A")
    office.apply(Suspended, "A")
    office.goal("B", "A")
    assert office.tree.status("B").suspended
    assert not office.handling("B")
    office.apply(Resumed, "A")
    assert office.handling("B")


def test_a_resumed_task_waits_for_one_above_it():
    office = Office()
    office.goal("A")
    office.apply(Suspended, "A")
    office.goal("B", "A")
    office.apply(Suspended, "B")
    office.apply(Resumed, "B")
    assert not office.handling("B")
    office.apply(Resumed, "A")
    assert office.handling("B")


def test_others_are_not_suspended():
    office = Office(capacity=1)
    office.command("A", flags=0)
    office.command("B", flags=0)
    office.command("C", flags=0)
    office.apply(Suspended, "B")
    office.done("A")
    assert office.handling("C")
    office.done("C")
    assert not office.handling("B")


def test_suspending_twice_is_suspending_once():
    office = Office(capacity=0)
    office.command("A")
    office.apply(Suspended, "A")
    assert office.apply(Suspended, "A") == []
    office.apply(Resumed, "A")
    assert office.apply(Resumed, "A") == []


def test_a_suspended_task_is_suspended_after_a_restart():
    office = Office(capacity=0)
    office.command("A")
    office.apply(Suspended, "A")
    tree = Tree(generation=1)
    tree.replay(office.records)
    assert tree.status("A").suspended


def test_the_clean_up_of_what_is_below_a_suspended_task_runs():
    office = Office()
    office.goal("A")
    office.command("a1", "A", attachments=[CLEAN])
    office.apply(Suspended, "A")
    office.apply(KillRequested, "a1", "enough")
    office.stop("a1")
    assert office.handling(office.sent("clean")[0])


@pytest.mark.bus
async def test_a_suspended_task_waits_and_is_resumed(user: Module, robot: Robot):
    task = await user.expand(Fetch(what="wait1+b"))
    await eventually(lambda: "wait1" in robot.done)
    status = await user.suspend(task)
    assert status.suspended
    robot.hold.set()

    async def next_is_held() -> bool:
        step = await user.relative(task, "last_child")
        return (step.data["name"], step.waiting_for) == ("b", "being resumed")

    await eventually(next_is_held)
    assert "b" not in robot.done
    await user.resume(task)
    await task.result(timeout=10.0)
    assert robot.done == ["wait1", "b"]
