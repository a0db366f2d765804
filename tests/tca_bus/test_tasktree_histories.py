"""Random histories of the task tree, and what must hold in each of them."""

from __future__ import annotations

from typing import Any

from hypothesis import settings
from hypothesis.stateful import invariant
from tree_changes import Changes

from tca_bus import Constraint, TaskState
from tca_bus._attachments import GATES
from tca_bus._protocol import Outcome
from tca_bus.tasktree import (
    Deregistered,
    HandlerMissing,
    KillRequested,
    Registered,
    Reported,
    Tree,
    decode_event,
    encode_event,
)


class Histories(Changes):
    """What holds after each change."""

    @invariant()
    def parents_end_after_what_is_below(self) -> None:
        for status in self.tree.statuses():
            parent = self.all.get(status.parent or "")
            if parent is not None and parent.is_ended:
                assert status.is_ended

    @invariant()
    def achieved_means_handled_and_all_below_ended(self) -> None:
        for status in self.tree.statuses():
            if status.state is TaskState.ACHIEVED:
                assert status.handling == "handled"
                assert status.planning == "planned"

    @invariant()
    def no_sequential_constraint_is_broken(self) -> None:
        for id, flags in self.flags.items():
            status, before = self.all[id], self.all.get(self.previous[id] or "")
            if before is None or before.is_ended or before.attempt > 1 or status.attempt > 1:
                continue
            if before.task_class == "monitor":
                continue
            if Constraint.SEQ_ACH in flags:
                assert status.achievement == "unachieved"
                assert status.task_class == "goal" or status.handling == "unhandled"
            if Constraint.SEQ_PLANNING in flags and status.task_class == "goal":
                assert before.planning == "planned" or status.planning == "unplanned"

    @invariant()
    def what_is_being_killed_is_told_to_stop(self) -> None:
        for status in self.tree.statuses():
            if status.existence == "terminating" and status.handling == "handling":
                assert status.id in self.cancelled

    @invariant()
    def only_what_runs_or_waits_for_something_is_left(self) -> None:
        for status in self.tree.statuses():
            if status.state in {TaskState.INACTIVE, TaskState.PENDING} and not status.is_ended:
                assert status.waiting_for

    @invariant()
    def what_is_handled_and_not_yet_done_says_what_holds_it(self) -> None:
        for status in self.tree.statuses():
            if status.handling == "handled" and not status.is_ended:
                assert status.waiting_for

    @invariant()
    def what_was_published_says_the_same_as_the_tree(self) -> None:
        for status in self.tree.statuses():
            if status.state in {TaskState.HANDLED, TaskState.PLANNED}:
                assert self.all[status.id].waiting_for == status.waiting_for

    @invariant()
    def no_stated_constraint_is_broken(self) -> None:
        for order in list(self.orders):
            first, then = order.first, order.then
            assert first is not None
            if then.task not in self.tree or first.task not in self.tree:
                self.orders.remove(order)
                continue
            one, two = self.tree.node(first.task), self.tree.node(then.task)
            if one.attempt > 1 or two.attempt > 1 or one.restarting or two.restarting:
                self.orders.remove(order)
            elif then.point in two.passed:
                assert first.point in one.passed, str(order)

    @invariant()
    def what_a_blocking_tap_holds_has_not_passed(self) -> None:
        for id in self.living():
            node = self.tree.node(id)
            parent = node.task.parent
            if node.role == "gate" and parent is not None and node.origin.gate is not None:
                tapped = self.tree.node(parent)
                assert node.origin.gate in GATES.values()
                if tapped.is_alive and not tapped.restarting and tapped.attempt < 2:
                    assert node.origin.gate not in tapped.passed

    @invariant()
    def nothing_suspended_is_given_to_a_handler(self) -> None:
        for status in self.tree.statuses():
            if status.suspended and status.handling == "unhandled":
                assert status.waiting_for

    def teardown(self) -> None:
        self.replay_gives_the_same_tree()
        for entry in self.tree.attachments():
            if isinstance(entry, Registered):
                self.happen(Deregistered(self.time, entry.id))
        rounds = 0
        while len(self.tree):
            for id in self.living():
                if id in self.tree and not self.tree.node(id).has_ended:
                    self.happen(KillRequested(self.time, id, "end of history"))
            for id, attempt in self.handled_now():
                self.happen(Reported(self.time, id, attempt, Outcome.KILLED))
            for id in list(self.waits):
                self.give_up(id)
            rounds += 1
            assert rounds < 50, [status.model_dump() for status in self.tree.statuses()]
        assert all(status.is_ended for status in self.all.values())

    def give_up(self, id: str) -> None:
        if self.tree.is_missing(id, self.waits.pop(id)):
            self.happen(HandlerMissing(self.time, id))

    def replay_gives_the_same_tree(self) -> None:
        events = [decode_event(*encode_event(record.event)) for record in self.records]
        again = Tree()
        again.replay(events)
        assert shown(again) == shown(self.tree)
        assert waits(again) == waits(self.tree)
        alive = [r.event for r in self.records if r.root not in self.ended_roots]
        short = Tree()
        short.replay(alive)
        assert shown(short, sequence=False) == shown(self.tree, sequence=False)


def shown(tree: Tree, *, sequence: bool = True) -> list[dict[str, Any]]:
    """The statuses, without what depends on the modules that are present now."""
    hidden = {"waiting_for"} | (set() if sequence else {"sequence"})
    return [status.model_dump(exclude=hidden) for status in tree.statuses()]


def waits(tree: Tree) -> dict[str, Any]:
    """What each point of each node waits for, and the alarms."""
    nodes = {status.id: tree.node(status.id) for status in tree.statuses()}
    return {
        id: (
            {point: list(sources) for point, sources in node.open.items() if sources},
            dict(node.alarms),
            sorted(node.passed),
        )
        for id, node in nodes.items()
    }


TestHistories = Histories.TestCase
TestHistories.settings = settings(max_examples=60, stateful_step_count=50, deadline=None)
