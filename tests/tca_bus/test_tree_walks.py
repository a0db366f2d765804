"""Walks and look-ups in the tree (tca.md 3.7): relatives by place, by name and by cause."""

from __future__ import annotations

import pytest
from tree_office import Office
from tree_robot import Fetch, Robot

from tca_bus import Catch, HandlerFailedError, Module, Relation, Tap, TapCondition
from tca_bus._attachments import Sending
from tca_bus.tasktree import find_relative
from tca_bus.testing import eventually

GATE = Tap(
    id="t",
    condition=TapCondition.BEFORE_ACHIEVING,
    listener=Sending(name="tap", task_class="command"),
)


def relative(office: Office, id: str, relation: Relation, name: str | None = None) -> str | None:
    return find_relative(office.tree, id, relation, name)


def family() -> Office:
    office = Office()
    office.goal("A")
    office.goal("B", "A", attachments=[Catch(id="c", handler="fix")])
    office.goal("C", "A", attachments=[GATE])
    office.command("b1", "B")
    office.command("b2", "B", 0)
    return office


def test_parents_ancestors_and_the_top_level_task():
    office = family()
    assert relative(office, "b1", Relation.PARENT) == "B"
    assert relative(office, "A", Relation.PARENT) is None
    assert relative(office, "b1", Relation.TOP_LEVEL) == "A"
    assert relative(office, "A", Relation.TOP_LEVEL) == "A"
    assert relative(office, "b1", Relation.ANCESTOR, "goal") == "B"
    assert relative(office, "b1", Relation.ANCESTOR, "command") is None


def test_children_and_siblings_in_the_order_of_their_sending():
    office = family()
    assert relative(office, "A", Relation.FIRST_CHILD) == "B"
    assert relative(office, "A", Relation.LAST_CHILD) == "C"
    assert relative(office, "B", Relation.NEXT) == "C"
    assert relative(office, "C", Relation.PREVIOUS) == "B"
    assert relative(office, "C", Relation.NEXT) is None
    assert relative(office, "b1", Relation.FIRST_CHILD) is None
    assert relative(office, "B", Relation.CHILD, "command") == "b1"


def test_walks_among_siblings_pass_listeners_over_and_look_ups_see_them():
    office = family()
    office.done("b1")
    office.done("b2")
    office.done("B")
    (listener,) = office.sent("tap")
    office.command("c1", "C")
    assert relative(office, "C", Relation.FIRST_CHILD) == "c1"
    assert relative(office, "c1", Relation.PREVIOUS) is None
    assert relative(office, "C", Relation.CHILD, "tap") == listener
    assert relative(office, listener, Relation.PARENT) == "C"


def test_from_a_listener_to_what_is_tapped_and_from_a_handler_to_what_failed():
    office = family()
    office.fail("b1")
    (recovery,) = office.sent("fix")
    office.command("more", recovery)
    assert relative(office, recovery, Relation.FAILED) == "b1"
    assert relative(office, "more", Relation.FAILED) == "b1"
    assert relative(office, "B", Relation.FAILED) is None
    office.done("more")
    office.done(recovery)
    office.done("b2")
    office.done("B")
    (listener,) = office.sent("tap")
    assert relative(office, listener, Relation.TAPPED) == "C"
    assert relative(office, "C", Relation.TAPPED) is None


def test_a_walk_from_nobody_is_an_error():
    with pytest.raises(KeyError):
        relative(family(), "nobody", Relation.PARENT)


@pytest.mark.bus
async def test_walks_find_relatives_by_place_and_by_name(user: Module, robot: Robot):
    task = await user.expand(Fetch(what="wait1+b"))
    await eventually(lambda: "wait1" in robot.done)
    first = await user.relative(task, "first_child")
    # The first child is at work before the goal has added the second.
    await eventually(lambda: user.relative(first.id, "next"))
    following = await user.relative(first.id, "next")
    assert [first.data["name"], following.data["name"]] == ["wait1", "b"]
    assert (await user.relative(first.id, "parent")).id == task.id
    assert (await user.relative(following.id, "previous")).id == first.id
    assert (await user.relative(following.id, "ancestor", name="fetch")).id == task.id
    assert await user.relative(task, "child", name="nothing") is None
    with pytest.raises(HandlerFailedError, match="no task 'nobody'"):
        await user.relative("nobody", "parent")
    robot.hold.set()
    await task.result(timeout=10.0)
