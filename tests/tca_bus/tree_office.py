"""A task tree with one module of great capacity, and short words for what happens to it."""

from __future__ import annotations

from typing import Any

from tca_bus import Constraint, Failure, TaskState, TaskStatus
from tca_bus._attachments import Attachment
from tca_bus._orders import Order, TaskRef
from tca_bus._protocol import Outcome, SubmitTask
from tca_bus.tasktree import (
    Alarmed,
    Attached,
    Constrained,
    Effect,
    Prepared,
    ProviderAppeared,
    Publish,
    Record,
    Registered,
    Reported,
    SetAlarm,
    Submitted,
    Tree,
)

S, P, F, D = (
    Constraint.SEQ_ACH,
    Constraint.SEQ_PLANNING,
    Constraint.PLAN_FIRST,
    Constraint.DELAY_PLANNING,
)


NAMES = ("goal", "command", "again", "tap", "fix", "other", "clean", "watch")


class Office:
    """A tree with one module of great capacity, and short words for what happens to it."""

    def __init__(self, *, capacity: int = 100) -> None:
        self.tree = Tree()
        self.time = 0.0
        self.records: list[Any] = []
        self.last: dict[str, TaskStatus] = {}
        self.alarms: dict[tuple[str, str], float] = {}
        self.appear("robot", "r1", capacity)

    def apply(self, kind: Any, *arguments: Any, **facts: Any) -> list[Effect]:
        self.time += 1.0
        return self.happen(kind(self.time, *arguments, **facts))

    def happen(self, event: Any) -> list[Effect]:
        effects = self.tree.apply(event)
        self.records += [effect.event for effect in effects if isinstance(effect, Record)]
        published = [effect.status for effect in effects if isinstance(effect, Publish)]
        self.last.update({status.id: status for status in published})
        self.alarms |= {(e.id, e.key): e.when for e in effects if isinstance(e, SetAlarm)}
        return effects

    def appear(self, module: str, incarnation: str, capacity: int = 100) -> list[Effect]:
        names = NAMES
        return self.apply(ProviderAppeared, module, incarnation, dict.fromkeys(names, capacity))

    def goal(self, id: str, parent: str | None = None, flags: int = S, **facts: Any) -> Any:
        return self.submit(id, "goal", parent, flags, **facts)

    def command(self, id: str, parent: str | None = None, flags: int = S, **facts: Any) -> Any:
        return self.submit(id, "command", parent, flags, **facts)

    def submit(self, id: str, kind: Any, parent: str | None, flags: int, **facts: Any) -> Any:
        values = {"name": kind, "data": {}, "sender": "me", **facts}
        task = SubmitTask(id=id, task_class=kind, parent=parent, constraints=int(flags), **values)
        self.tree.check(task)
        return self.apply(Submitted, task)

    def prepare(self, id: str, kind: Any = "command", parent: str | None = None) -> TaskRef:
        self.tree.check_prepare(id, parent)
        self.apply(Prepared, id, kind, kind, "me", parent)
        return TaskRef(id)

    def constrain(self, *orders: Order) -> None:
        for order in orders:
            self.tree.check_order(order)
        self.tree.check_orders(orders)
        for order in orders:
            self.apply(Constrained, order)

    def attach(self, id: str, what: Attachment) -> list[Effect]:
        self.tree.check_attachment(what)
        return self.apply(Attached, id, what)

    def register(self, message: str, what: Attachment) -> list[Effect]:
        self.tree.check_attachment(what)
        return self.apply(Registered, message, what)

    def wake(self) -> float:
        """Let the earliest time come for which something waits; gives it."""
        id, key = min(self.alarms, key=lambda alarm: self.alarms[alarm])
        self.time = max(self.time, self.alarms.pop((id, key)))
        self.happen(Alarmed(self.time, id, key))
        return self.time

    def sent(self, name: str) -> list[str]:
        """The ids of the living nodes of a message that central sent itself."""
        return [s.id for s in self.tree.statuses() if s.name == name and s.sender == "central"]

    def passed(self, id: str) -> set[str]:
        return {point.value for point in self.tree.node(id).passed}

    def done(self, id: str, **facts: Any) -> list[Effect]:
        outcome = facts.pop("outcome", Outcome.SUCCESS)
        attempt = facts.pop("attempt", self.last[id].attempt)
        return self.apply(Reported, id, attempt, outcome, **facts)

    def fail(self, id: str, name: str = "broken", *, kinds: tuple[str, ...] = ()) -> list[Effect]:
        why = Failure(name=name, text="it broke", kinds=kinds)
        return self.done(id, outcome=Outcome.FAILURE, failure=why)

    def stop(self, id: str) -> list[Effect]:
        return self.done(id, outcome=Outcome.KILLED)

    def handling(self, *ids: str) -> bool:
        return all(self.last[id].handling == "handling" for id in ids)

    def state(self, id: str) -> TaskState:
        state: TaskState = self.last[id].state
        return state


def only(effects: list[Effect], kind: Any) -> list[Any]:
    return [effect for effect in effects if isinstance(effect, kind)]
