"""Random changes of a task tree, and a model of what was sent to whom."""

from __future__ import annotations

from typing import Any

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, precondition, rule

from tca_bus import Constraint, Failure, RefusedError, TaskStatus
from tca_bus._attachments import Catch, CleanUp, Resolution, Sending, Tap, TapCondition
from tca_bus._monitor_spec import MonitorSpec
from tca_bus._orders import NAMEABLE, Order, PointRef
from tca_bus._protocol import ENDED, Outcome, SubmitTask
from tca_bus.tasktree import (
    Abandoned,
    Alarmed,
    Attached,
    Cancel,
    Constrained,
    Deregistered,
    Dispatch,
    Effect,
    Ended,
    Freed,
    HandlerMissing,
    KillRequested,
    Prepared,
    Prioritized,
    ProviderAppeared,
    ProviderLost,
    Publish,
    Record,
    Registered,
    Reported,
    Resumed,
    Retried,
    SetAlarm,
    Submitted,
    Suspended,
    Taken,
    Tree,
    Triggered,
    WaitForHandler,
)

CLASSES = st.sampled_from(["goal", "command"])
FLAGS = st.integers(0, 15).filter(lambda flags: flags & 12 != 12)
POLICY = st.sampled_from(["fail", "resend", "hold"])
PICK = st.integers(0, 10_000)
POINTS = st.sampled_from(sorted(NAMEABLE))
RELATIONS = st.sampled_from(["<", "<=", "="])
NAMES = ("name0", "name1", "fix", "clean", "tap")
LISTENER = Sending(name="tap", task_class="command")
CATCH = Catch(id="c", exception="broken", handler="fix", max_invocations=2)
RESOLUTIONS = st.sampled_from(
    [
        Resolution(),
        Resolution(action="bypass"),
        Resolution(action="retry", most=1),
        Resolution(action="retry", task="n1", most=1),
    ]
)
CONDITIONS = st.sampled_from([c for c in TapCondition if c != TapCondition.AFTER_REPLIED])


class Changes(RuleBasedStateMachine):
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
        self.alarms: dict[tuple[str, str], float] = {}
        self.orders: list[Order] = []

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
            case SetAlarm(id=id, key=key, when=when):
                self.alarms[id, key] = when
            case Cancel(id=id):
                self.cancelled.add(id)
            case Publish(status=status):
                self.publish(status)
            case WaitForHandler(id=id, number=number):
                self.waits[id] = number
            case Freed(status=status):
                assert status.is_ended
                assert self.all[status.id] == status
            case Ended(root=root):
                assert root not in self.ended_roots
                self.ended_roots.add(root)

    def publish(self, status: TaskStatus) -> None:
        before = self.all.get(status.id)
        if before is not None:
            assert status.sequence > before.sequence
            assert before.state not in ENDED
        self.all[status.id] = status

    def pick(self, choices: list[Any], number: int) -> Any:
        return choices[number % len(choices)]

    def handled_now(self) -> list[tuple[str, int]]:
        return [key for key in self.running if self.tree.is_current(*key)]

    def living(self) -> list[str]:
        return [status.id for status in self.tree.statuses()]

    @rule(
        pick=PICK,
        kind=CLASSES,
        flags=FLAGS,
        policy=POLICY,
        sender=st.sampled_from("ab"),
        extra=st.integers(0, 7),
        go_on=st.booleans(),
    )
    def submit(
        self,
        pick: int,
        kind: Any,
        flags: int,
        policy: Any,
        sender: str,
        extra: int,
        go_on: bool,
    ) -> None:
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
            on_unhandled="go_on" if go_on else "fail_parent",
            priority=pick % 3,
            within=float(pick % 50 + 1) if extra & 4 else None,
            attachments=self.attachments(extra),
        )
        try:
            self.happen(Submitted(self.time, task))
        except RefusedError:
            assert flags & Constraint.DELAY_PLANNING
            return
        if task.id not in self.tree:
            assert self.all[task.id].is_ended
            return
        self.flags[task.id] = Constraint(flags)
        key = (parent, sender if parent is None else "")
        self.previous[task.id] = self.last_child.get(key)
        self.last_child[key] = task.id
        assert self.tree.apply(Submitted(self.time, task)) == []

    def attachments(self, extra: int) -> tuple[Any, ...]:
        clean = CleanUp(id=f"u{self.serial}", sending=Sending(name="clean", task_class="command"))
        catch = CATCH.model_copy(update={"id": f"c{self.serial}"})
        return ((clean,) if extra & 1 else ()) + ((catch,) if extra & 2 else ())

    @precondition(lambda self: self.handled_now())
    @rule(pick=PICK, kind=st.sampled_from(["point", "polling", "demon"]), most=st.integers(1, 3))
    def monitor(self, pick: int, kind: Any, most: int) -> None:
        parent, _ = self.pick(self.handled_now(), pick)
        self.serial += 1
        action = Sending(name="name0", task_class="command", data={"x": 1})
        task = SubmitTask(
            id=f"n{self.serial}",
            name="name1",
            task_class="monitor",
            data={},
            sender="a",
            parent=parent,
            constraints=0,
            on_module_lost="resend",
            monitor=MonitorSpec(kind=kind, action=action, fire_every=pick % 2 + 1, max_fire=most),
        )
        self.happen(Submitted(self.time, task))
        if kind == "point":
            # It tests at its place among the siblings; the others are passed over.
            self.previous[task.id] = self.last_child.get((parent, ""))
            self.last_child[parent, ""] = task.id

    @precondition(lambda self: self.handled_now())
    @rule(pick=PICK)
    def trigger(self, pick: int) -> None:
        watching = [key for key in self.handled_now() if self.tree.node(key[0]).is_interval_monitor]
        if watching:
            id, attempt = self.pick(watching, pick)
            watch = self.tree.node(id).watch
            assert watch is not None
            self.happen(Triggered(self.time, id, attempt, watch.told + 1, {"x": 2}))

    @precondition(lambda self: len(self.tree) > 1)
    @rule(pick=PICK, other=PICK, first=POINTS, then=POINTS, relation=RELATIONS, delay=st.booleans())
    def constrain(
        self, pick: int, other: int, first: Any, then: Any, relation: Any, delay: bool
    ) -> None:
        one, two = self.pick(self.living(), pick), self.pick(self.living(), other)
        if (one, first) == (two, then):
            return
        order = Order(
            first=PointRef(task=one, point=first),
            relation=relation,
            then=PointRef(task=two, point=then),
            delay=2.0 if delay and relation != "=" else 0.0,
        )
        try:
            self.tree.check_order(order)
        except RefusedError:
            return
        self.happen(Constrained(self.time, order))
        self.orders.append(order)

    @precondition(lambda self: self.alarms)
    @rule(pick=PICK)
    def wake(self, pick: int) -> None:
        id, key = self.pick(list(self.alarms), pick)
        when = self.alarms.pop((id, key))
        if self.tree.is_awaited(id, key):
            self.time = max(self.time, when)
            self.happen(Alarmed(self.time, id, key))
            assert not self.tree.is_awaited(id, key)

    @precondition(lambda self: len(self.tree) > 0)
    @rule(pick=PICK, change=st.sampled_from([Suspended, Resumed, Retried]))
    def change(self, pick: int, change: Any) -> None:
        self.happen(change(self.time, self.pick(self.living(), pick)))

    @precondition(lambda self: len(self.tree) > 0)
    @rule(pick=PICK, priority=st.integers(0, 3))
    def prioritize(self, pick: int, priority: int) -> None:
        self.happen(Prioritized(self.time, self.pick(self.living(), pick), priority))

    @precondition(lambda self: self.handled_now())
    @rule(pick=PICK)
    def prepare(self, pick: int) -> None:
        parent, _ = self.pick(self.handled_now(), pick)
        self.serial += 1
        self.happen(Prepared(self.time, f"n{self.serial}", "name0", "goal", "a", parent))

    @rule(pick=PICK, flags=FLAGS)
    def fill(self, pick: int, flags: int) -> None:
        places = [id for id in self.living() if self.tree.node(id).prepared]
        if not places:
            return
        place = self.tree.node(self.pick(places, pick)).task
        task = place.model_copy(update={"constraints": flags, "wait_for_handler": 1.0})
        try:
            self.tree.check(task)
        except RefusedError:
            return
        self.happen(Submitted(self.time, task))

    @rule(condition=CONDITIONS, on_failure=st.sampled_from(["ignore", "fail"]), pick=PICK)
    def tap(self, condition: TapCondition, on_failure: Any, pick: int) -> None:
        self.serial += 1
        tap = Tap(
            id=f"t{self.serial}", condition=condition, listener=LISTENER, on_failure=on_failure
        )
        if pick % 2 or not self.living():
            self.happen(Registered(self.time, f"name{pick % 3 % 2}", tap))
        else:
            self.happen(Attached(self.time, self.pick(self.living(), pick), tap))

    @rule(pick=PICK)
    def catch(self, pick: int) -> None:
        self.serial += 1
        catch = CATCH.model_copy(update={"id": f"c{self.serial}"})
        self.happen(Registered(self.time, f"name{pick % 2}", catch))

    @rule(pick=PICK)
    def deregister(self, pick: int) -> None:
        entries = [e for e in self.tree.attachments() if isinstance(e, Registered)]
        if entries:
            self.happen(Deregistered(self.time, self.pick(entries, pick).id))

    @precondition(lambda self: self.cancelled)
    @rule(pick=PICK)
    def abandon(self, pick: int) -> None:
        id = self.pick(sorted(self.cancelled), pick)
        if id in self.tree and self.tree.node(id).is_handling:
            self.happen(Abandoned(self.time, id, self.tree.node(id).attempt))

    @precondition(lambda self: self.handled_now())
    @rule(pick=PICK)
    def take(self, pick: int) -> None:
        id, attempt = self.pick(self.handled_now(), pick)
        self.happen(Taken(self.time, id, attempt))

    @precondition(lambda self: self.handled_now())
    @rule(pick=PICK, outcome=st.sampled_from(Outcome), saw=st.booleans(), decision=RESOLUTIONS)
    def report(self, pick: int, outcome: Outcome, saw: bool, decision: Resolution) -> None:
        id, attempt = self.pick(self.handled_now(), pick)
        failed = [s.id for s in self.all.values() if s.parent == id and s.state == "failed"]
        failure = Failure(name="broken", text="it broke") if outcome == "failure" else None
        seen = tuple(failed) if saw else ()
        monitor = self.tree.node(id).task.monitor
        result = {"satisfied": saw, "data": {}} if monitor else 1
        report = (outcome, result, failure, seen, decision)
        self.happen(Reported(self.time, id, attempt, *report))
        again = Reported(self.time, id, attempt, *report)
        if not self.tree.is_current(id, attempt):
            assert self.tree.apply(again) == []

    @precondition(lambda self: len(self.tree) > 0)
    @rule(pick=PICK, only_below=st.booleans())
    def kill(self, pick: int, only_below: bool) -> None:
        id = self.pick([status.id for status in self.tree.statuses()], pick)
        before = {
            s.id
            for s in self.tree.statuses(id)
            if not any(
                self.tree.node(above).role == "clean-up" for above in [s.id, *self.above(s.id)]
            )
        } - ({id} if only_below else set())
        self.happen(KillRequested(self.time, id, "no more", only_below))
        for below in before & {status.id for status in self.tree.statuses()}:
            status = self.tree.status(below)
            assert status.existence != "alive"

    def above(self, id: str) -> list[str]:
        found: list[str] = []
        parent = self.tree.node(id).task.parent
        while parent is not None:
            found.append(parent)
            parent = self.tree.node(parent).task.parent
        return found

    @rule(number=st.integers(1, 3), names=st.integers(1, 31), capacity=st.integers(1, 2))
    def appear(self, number: int, names: int, capacity: int) -> None:
        module = f"m{number}"
        if module in self.present.values():
            return
        self.serial += 1
        incarnation = f"{module}-{self.serial}"
        handles = [name for bit, name in enumerate(NAMES) if names & 1 << bit]
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
            failed = id not in self.tree or self.tree.node(id).failing
            assert failed or self.all[id].failure or self.tree.node(id).answered
