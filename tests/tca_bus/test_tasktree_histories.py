"""Random histories of the task tree, and what must hold in each of them."""

from __future__ import annotations

from typing import Any

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from tca_bus import Constraint, Failure, RefusedError, TaskState, TaskStatus
from tca_bus._protocol import ENDED, Outcome, SubmitTask
from tca_bus.tasktree import (
    Cancel,
    Dispatch,
    Effect,
    Ended,
    HandlerMissing,
    KillRequested,
    ProviderAppeared,
    ProviderLost,
    Publish,
    Record,
    Reported,
    Submitted,
    Taken,
    Tree,
    WaitForHandler,
    decode_event,
    encode_event,
)

CLASSES = st.sampled_from(["goal", "command"])
FLAGS = st.integers(0, 15).filter(lambda flags: flags & 12 != 12)
POLICY = st.sampled_from(["fail", "resend"])
PICK = st.integers(0, 10_000)


class Histories(RuleBasedStateMachine):
    """Modules that come, work, fail and die; a model of what was sent to whom."""

    def __init__(self) -> None:
        super().__init__()
        self.tree = Tree()
        self.time = 0.0
        self.serial = 0
        self.records: list[Record] = []
        self.ended_roots: set[str] = set()
        self.all: dict[str, TaskStatus] = {}
        self.flags: dict[str, Constraint] = {}
        self.previous: dict[str, str | None] = {}
        self.last_child: dict[tuple[str | None, str], str] = {}
        self.running: dict[tuple[str, int], str] = {}
        self.cancelled: set[str] = set()
        self.present: dict[str, str] = {}
        self.waits: dict[str, int] = {}
        self.order: list[tuple[str, str]] = []

    def happen(self, event: Any) -> list[Effect]:
        self.time += 1.0
        effects = self.tree.apply(event)
        for effect in effects:
            self.note(effect)
        return effects

    def note(self, effect: Effect) -> None:
        match effect:
            case Record():
                self.records.append(effect)
            case Dispatch(id=id, attempt=attempt):
                assert (id, attempt) not in self.running
                self.running[id, attempt] = effect.incarnation
                self.order.append(("dispatch", id))
            case Cancel(id=id):
                self.cancelled.add(id)
            case Publish(status=status):
                self.publish(status)
            case WaitForHandler(id=id, number=number):
                self.waits[id] = number
            case Ended(root=root, statuses=statuses):
                assert root not in self.ended_roots
                assert all(status.is_ended for status in statuses)
                self.ended_roots.add(root)

    def publish(self, status: TaskStatus) -> None:
        before = self.all.get(status.id)
        if before is not None:
            assert status.sequence > before.sequence
            assert before.state not in ENDED
        self.all[status.id] = status
        if status.is_ended:
            self.order.append(("end", status.id))

    def pick(self, choices: list[Any], number: int) -> Any:
        return choices[number % len(choices)]

    def handled_now(self) -> list[tuple[str, int]]:
        return [key for key in self.running if self.tree.is_current(*key)]

    @rule(pick=PICK, kind=CLASSES, flags=FLAGS, policy=POLICY, sender=st.sampled_from("ab"))
    def submit(self, pick: int, kind: Any, flags: int, policy: Any, sender: str) -> None:
        parents = [None, *[id for id, _ in self.handled_now()]]
        parent = self.pick(parents, pick)
        self.serial += 1
        task = SubmitTask(
            id=f"n{self.serial}",
            name=f"name{pick % 2}",
            task_class=kind,
            data={},
            sender=sender,
            parent=parent,
            constraints=flags,
            on_module_lost=policy,
            priority=pick % 3,
        )
        try:
            self.happen(Submitted(self.time, task))
        except RefusedError:
            assert flags & Constraint.DELAY_PLANNING
            return
        self.flags[task.id] = Constraint(flags)
        key = (parent, sender if parent is None else "")
        self.previous[task.id] = self.last_child.get(key)
        self.last_child[key] = task.id
        assert self.tree.apply(Submitted(self.time, task)) == []

    @precondition(lambda self: self.handled_now())
    @rule(pick=PICK)
    def take(self, pick: int) -> None:
        id, attempt = self.pick(self.handled_now(), pick)
        self.happen(Taken(self.time, id, attempt))

    @precondition(lambda self: self.handled_now())
    @rule(pick=PICK, outcome=st.sampled_from(Outcome), saw=st.booleans())
    def report(self, pick: int, outcome: Outcome, saw: bool) -> None:
        id, attempt = self.pick(self.handled_now(), pick)
        failed = [s.id for s in self.all.values() if s.parent == id and s.state == "failed"]
        failure = Failure(name="broken", text="it broke") if outcome == "failure" else None
        seen = tuple(failed) if saw else ()
        self.order.append(("handled", id))
        self.happen(Reported(self.time, id, attempt, outcome, 1, failure, seen))
        again = Reported(self.time, id, attempt, outcome, 1, failure, seen)
        if not self.tree.is_current(id, attempt):
            assert self.tree.apply(again) == []

    @precondition(lambda self: len(self.tree) > 0)
    @rule(pick=PICK, only_below=st.booleans())
    def kill(self, pick: int, only_below: bool) -> None:
        id = self.pick([status.id for status in self.tree.statuses()], pick)
        before = {s.id for s in self.tree.statuses(id) if not s.is_ended} - (
            {id} if only_below else set()
        )
        self.happen(KillRequested(self.time, id, "no more", only_below))
        for below in before & {status.id for status in self.tree.statuses()}:
            status = self.tree.status(below)
            assert status.existence != "alive"

    @rule(number=st.integers(1, 3), names=st.integers(1, 3), capacity=st.integers(1, 2))
    def appear(self, number: int, names: int, capacity: int) -> None:
        module = f"m{number}"
        if module in self.present.values():
            return
        self.serial += 1
        incarnation = f"{module}-{self.serial}"
        handles = [name for bit, name in ((1, "name0"), (2, "name1")) if names & bit]
        self.present[incarnation] = module
        self.happen(
            ProviderAppeared(self.time, module, incarnation, dict.fromkeys(handles, capacity))
        )

    @precondition(lambda self: self.present)
    @rule(pick=PICK)
    def lose(self, pick: int) -> None:
        incarnation = self.pick(list(self.present), pick)
        del self.present[incarnation]
        self.happen(ProviderLost(self.time, incarnation))
        for key, holder in self.running.items():
            assert holder != incarnation or not self.tree.is_current(*key)

    @precondition(lambda self: self.waits)
    @rule(pick=PICK)
    def give_up_waiting(self, pick: int) -> None:
        id = self.pick(list(self.waits), pick)
        if self.tree.is_missing(id, self.waits.pop(id)):
            self.happen(HandlerMissing(self.time, id))
            assert self.all[id].failure is not None

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
            if before is None or before.is_ended:
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

    def teardown(self) -> None:
        self.replay_gives_the_same_tree()
        for root in self.tree.roots():
            self.happen(KillRequested(self.time, root, "end of history"))
        for id, attempt in self.handled_now():
            self.happen(Reported(self.time, id, attempt, Outcome.KILLED))
        assert len(self.tree) == 0
        assert all(status.is_ended for status in self.all.values())

    def replay_gives_the_same_tree(self) -> None:
        events = [decode_event(*encode_event(record.event)) for record in self.records]
        again = Tree()
        again.replay(events)
        assert shown(again) == shown(self.tree)
        alive = [r.event for r in self.records if r.root not in self.ended_roots]
        short = Tree()
        short.replay(alive)
        assert shown(short, sequence=False) == shown(self.tree, sequence=False)


def shown(tree: Tree, *, sequence: bool = True) -> list[dict[str, Any]]:
    """The statuses, without what depends on the modules that are present now."""
    hidden = {"waiting_for"} | (set() if sequence else {"sequence"})
    return [status.model_dump(exclude=hidden) for status in tree.statuses()]


TestHistories = Histories.TestCase
TestHistories.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
