"""Handlers' resources in the task tree: groups, order, limits, gates."""

from __future__ import annotations

import pytest

from tca_bus._protocol import Outcome, SubmitTask
from tca_bus.tasktree import (
    Dispatch,
    Freed,
    Gate,
    GateChanged,
    HandlerResource,
    ProviderAppeared,
    ProviderLost,
    Record,
    Reported,
    Submitted,
    Tree,
)


class Office:
    """A tree and what was dispatched in it."""

    def __init__(self):
        self.tree = Tree()
        self.dispatched = []
        self.to = {}
        self.ended = {}
        self.records = []

    def apply(self, event):
        for effect in self.tree.apply(event):
            if isinstance(effect, Freed):
                self.ended[effect.status.id] = effect.status
            if isinstance(effect, Dispatch):
                self.dispatched.append(effect.id)
                self.to[effect.id] = effect.incarnation
            elif isinstance(effect, Record):
                self.records.append(effect.event)

    def appear(self, *resources, module="robot", incarnation="r1", **facts):
        names = ("grasp", "wave", "drive")
        event = ProviderAppeared(
            0.0, module, incarnation, dict.fromkeys(names, 1), resources=resources, **facts
        )
        self.apply(event)

    def send(self, name, id, *, priority=0, sender="me"):
        task = SubmitTask(
            id=id,
            name=name,
            task_class="command",
            data={},
            sender=sender,
            constraints=0,
            priority=priority,
        )
        self.apply(Submitted(0.0, task))

    def done(self, *ids):
        for id in ids:
            self.apply(Reported(0.0, id, 1, Outcome.SUCCESS))

    def gate(self, resource, gate):
        self.apply(GateChanged(0.0, resource, gate))


ARM = HandlerResource("arm", 1, ("grasp", "wave"))


def test_handlers_of_one_resource_exclude_each_other():
    here = Office()
    here.appear(ARM)
    here.send("grasp", "g")
    here.send("wave", "w")
    here.send("drive", "d")
    assert here.dispatched == ["g", "d"]
    assert here.tree.status("w").waiting_for == "robot, which has 1 in its resource 'arm'"
    here.done("g")
    assert here.dispatched == ["g", "d", "w"]


def test_a_message_outside_all_resources_has_a_capacity_of_its_own():
    here = Office()
    here.appear()
    for name in ("grasp", "wave", "drive", "drive"):
        here.send(name, f"{name}{len(here.records)}")
    assert len(here.dispatched) == 3


def test_a_resource_is_first_come_first_served_across_its_messages():
    here = Office()
    here.appear(ARM)
    for name, id in (("grasp", "a"), ("wave", "b"), ("grasp", "c"), ("wave", "d"), ("wave", "e")):
        here.send(name, id)
    here.done("a", "b", "c", "d")
    assert here.dispatched == ["a", "b", "c", "d", "e"]


def test_a_higher_priority_goes_first_across_the_messages_of_a_resource():
    here = Office()
    here.appear(ARM)
    here.send("grasp", "a")
    here.send("grasp", "b")
    here.send("wave", "c", priority=1)
    here.done("a", "c")
    assert here.dispatched == ["a", "c", "b"]


def test_what_waits_can_be_given_another_priority_and_keeps_its_age():
    here = Office()
    here.appear(ARM)
    for id in "abcd":
        here.send("grasp", id)
    here.tree.pools.reprioritise("d", 5)
    here.tree.pools.reprioritise("c", 5)
    here.done("a", "c", "d")
    assert here.dispatched == ["a", "c", "d", "b"]


def test_the_own_resource_of_a_module_bounds_all_its_handlers():
    here = Office()
    here.appear(HandlerResource("", 2, ("grasp", "wave", "drive")))
    for name in ("grasp", "wave", "drive"):
        here.send(name, name)
    assert here.dispatched == ["grasp", "wave"]
    here.done("wave")
    assert here.dispatched[-1] == "drive"


def test_a_pool_has_one_queue_from_which_any_free_module_takes():
    here = Office()
    here.appear(ARM)
    here.appear(ARM, module="other", incarnation="o1")
    for id in "abcd":
        here.send("grasp", id)
    assert {here.to["a"], here.to["b"]} == {"r1", "o1"}
    here.done("b")
    assert here.to["c"] == here.to["b"]
    here.done("a")
    assert here.to["d"] == here.to["a"]


def test_of_too_many_waiting_the_oldest_fails_and_says_so():
    here = Office()
    here.appear(limits={"grasp": 2})
    for id in "abcd":
        here.send("grasp", id)
    failure = here.ended["b"].failure
    assert failure.name == "pending_limit"
    assert failure.data == {"resource": "robot/grasp", "limit": 2}
    assert here.tree.pools.dropped("robot/grasp") == 1
    here.done("a", "c")
    assert here.dispatched == ["a", "c", "d"]


def test_a_limit_drops_the_lowest_priority_first_even_the_newcomer():
    here = Office()
    here.appear(limits={"grasp": 1})
    here.send("grasp", "a")
    here.send("grasp", "b", priority=2)
    here.send("grasp", "c", priority=1)
    assert set(here.ended) == {"c"}
    here.send("grasp", "d", priority=3)
    assert set(here.ended) == {"b", "c"}


def test_a_limit_does_not_count_what_is_taken_at_once():
    here = Office()
    for id in "abc":
        here.apply(
            Submitted(
                0.0,
                SubmitTask(
                    id=id,
                    name="grasp",
                    task_class="command",
                    data={},
                    sender="me",
                    constraints=0,
                    wait_for_handler=5,
                ),
            )
        )
    here.appear(limits={"grasp": 2})
    assert here.dispatched == ["a"]
    assert here.ended == {}


def test_after_a_drop_the_newest_takes_the_last_place_of_its_message():
    here = Office()
    here.appear(ARM, limits={"grasp": 2})
    for name, id in (("wave", "x"), ("grasp", "a"), ("wave", "y"), ("grasp", "b"), ("wave", "z")):
        here.send(name, id)
    here.send("grasp", "c")
    here.done("x", "b", "y", "c")
    assert here.dispatched == ["x", "b", "y", "c", "z"]


def test_a_limit_of_a_resource_counts_all_its_messages():
    here = Office()
    here.appear(HandlerResource("arm", 1, ("grasp", "wave"), pending=2))
    for name, id in (("wave", "x"), ("grasp", "a"), ("wave", "b"), ("grasp", "c")):
        here.send(name, id)
    assert set(here.ended) == {"a"}
    assert here.tree.pools.dropped("robot/arm") == 1


def test_of_a_pool_the_module_that_lets_more_wait_decides():
    here = Office()
    here.appear(limits={"grasp": 1})
    here.appear(module="other", incarnation="o1", limits={"grasp": 2})
    for id in "abcd":
        here.send("grasp", id)
    assert here.ended == {}
    here.send("grasp", "e")
    assert set(here.ended) == {"c"}


def test_a_drop_is_replayed():
    here = Office()
    here.appear(limits={"grasp": 1})
    for id in "abc":
        here.send("grasp", id)
    again = Tree()
    again.replay(here.records)
    assert [status.id for status in again.statuses()] == ["a", "c"]


def test_a_locked_resource_passes_nobody_and_others_go_on():
    here = Office()
    here.appear(ARM)
    here.gate("robot/arm", Gate("lock-1"))
    here.send("grasp", "g")
    here.send("drive", "d")
    assert here.dispatched == ["d"]
    assert here.tree.status("g").waiting_for == "robot, which is held by lock-1"
    here.gate("robot/arm", None)
    assert here.dispatched == ["d", "g"]


def test_a_reserved_resource_passes_only_the_reservers_messages():
    here = Office()
    here.appear(ARM)
    here.gate("robot/arm", Gate("reservation-1", only="you"))
    here.send("grasp", "mine", sender="me")
    here.send("wave", "yours", sender="you")
    assert here.dispatched == ["yours"]
    here.done("yours")
    here.gate("robot/arm", None)
    assert here.dispatched == ["yours", "mine"]


def test_who_holds_a_modules_own_resource_holds_all_its_handlers():
    here = Office()
    here.appear(ARM)
    here.gate("robot/", Gate("lock-1"))
    for name in ("grasp", "drive"):
        here.send(name, name)
    assert here.dispatched == []


def test_a_module_that_is_not_known_yet_gets_nothing_while_any_of_its_resources_is_held():
    here = Office()
    here.gate("robot/arm", Gate("lock-1"))
    here.appear(is_introduced=False)
    here.send("grasp", "g")
    here.send("drive", "d")
    assert here.dispatched == []
    here.appear(ARM)
    assert here.dispatched == ["d"]


def test_a_gate_outlives_the_module_behind_it():
    here = Office()
    here.appear(ARM)
    here.gate("robot/arm", Gate("lock-1"))
    here.apply(ProviderLost(0.0, "r1"))
    here.appear(ARM, incarnation="r2")
    here.send("grasp", "g")
    assert here.dispatched == []
    here.gate("robot/arm", None)
    assert here.to["g"] == "r2"


@pytest.mark.parametrize(("first", "second"), [((1, 0), (1, 2)), ((0, 9), (1, 0)), (-1, 0)])
def test_priorities_may_have_parts(first, second):
    pools = Tree().pools
    pools.wait("low", "grasp", first)
    pools.wait("high", "grasp", second)
    pools.appear("robot", "r1", {"grasp": 1})
    choice = pools.assign()
    assert choice is not None
    assert choice.id == "high"


def test_who_is_told_to_wait_again_keeps_its_age_and_may_wait_for_one_module():
    pools = Tree().pools
    for id in "ab":
        pools.wait(id, "grasp", 0)
    pools.wait("a", "grasp", 0, only="other")
    pools.appear("robot", "r1", {"grasp": 2})
    assert [id for id, _ in pools.newly_missing()] == ["a"]
    choice = pools.assign()
    assert choice is not None
    assert choice.id == "b"
    pools.appear("other", "o1", {"grasp": 1})
    choice = pools.assign()
    assert choice is not None
    assert (choice.id, choice.module) == ("a", "other")
    pools.lose("o1")
    assert [id for id, _ in pools.newly_missing()] == ["a"]


def test_a_module_that_changes_its_messages_keeps_its_groups_until_it_says_more():
    here = Office()
    here.appear(ARM)
    here.send("grasp", "g")
    here.apply(
        ProviderAppeared(
            0.0, "robot", "r1", dict.fromkeys(("grasp", "wave", "new"), 1), is_introduced=False
        )
    )
    here.send("wave", "w")
    here.send("new", "n")
    assert here.dispatched == ["g", "n"]
