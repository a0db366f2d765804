"""Priorities (tca.md 8): of whole tasks, of messages within them, and changed while they wait."""

from __future__ import annotations

import pytest
from tree_office import Office
from tree_robot import Robot

from tca_bus import Command, Constraint, Module, TaskContext
from tca_bus.tasktree import Prioritized
from tca_bus.testing import eventually


def order_of(office: Office, ids: str) -> str:
    """The order in which the commands are handled, one at a time."""
    found = ""
    while len(found) < len(ids):
        (running,) = [id for id in ids if id not in found and office.handling(id)]
        found += running
        office.done(running)
    return found


def test_the_highest_goes_first_and_among_equals_the_one_that_came_first():
    office = Office(capacity=1)
    for id, priority in {"a": 0, "b": 1, "c": 5, "d": 1, "e": -1}.items():
        office.command(id, flags=0, priority=priority)
    assert order_of(office, "abcde") == "acbde"


def test_the_priority_of_the_whole_task_is_before_that_within_it():
    office = Office(capacity=1)
    office.goal("A", flags=0, priority=1)
    office.command("x", flags=0)
    office.command("a", "A", 0, priority=-5)
    office.command("b", "A", 0, priority=9)
    office.command("y", flags=0, priority=0)
    assert order_of(office, "xaby") == "xbay"


def test_a_task_that_is_given_another_priority_moves_with_all_below_it():
    office = Office(capacity=1)
    office.command("x", flags=0)
    office.goal("A", flags=0)
    office.command("y", flags=0, priority=1)
    office.command("a", "A", 0)
    office.command("b", "A", 0)
    office.apply(Prioritized, "A", 2)
    assert office.tree.status("A").priority == 2
    assert order_of(office, "xyab") == "xaby"


def test_a_message_that_is_given_another_priority_moves_within_its_task():
    office = Office(capacity=1)
    office.command("x", flags=0)
    office.goal("A", flags=0)
    for id in "abc":
        office.command(id, "A", 0)
    office.apply(Prioritized, "c", 1)
    assert order_of(office, "xabc") == "xcab"


def test_constraints_are_before_priorities():
    office = Office(capacity=1)
    office.command("x", flags=0)
    office.command("a", priority=1)
    office.command("b", priority=9)
    assert order_of(office, "xab") == "xab"


@pytest.mark.bus
async def test_what_waits_is_put_in_order_again(user: Module, robot: Robot):
    class Slow(Command[None]):
        """One at a time."""

        name: str

    async def slow(order: Slow, _: TaskContext) -> None:
        robot.done.append(order.name)
        await robot.hold.wait()

    robot.module.serve(Slow, slow)
    await user.wait_for(Slow, timeout=10.0)
    free = Constraint.NONE
    tasks = [await user.execute(Slow(name=name), constraints=free) for name in "abc"]
    await eventually(lambda: robot.done == ["a"])
    await user.prioritize(tasks[2], 5)
    robot.hold.set()
    for task in tasks:
        await task.result(timeout=10.0)
    assert robot.done == ["a", "c", "b"]
