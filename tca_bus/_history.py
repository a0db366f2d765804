"""The task history: what each journalled event says to people, and in TCA's log.

Each kind of event has a teller in `TELLERS`; a new kind needs one there and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from tca_bus._attachments import Attachment, Catch, CleanUp, Resolution, Tap
from tca_bus._failure import Failure
from tca_bus._log_statements import (
    Answered,
    ConstraintAdded,
    ConstraintWord,
    DemonFired,
    IntervalWord,
    KillAwaited,
    MessagePassed,
    MessageWord,
    NodeKilled,
    NodeRef,
    PointsOrdered,
    Remark,
    RetryAsked,
    Statement,
    TimePoint,
)
from tca_bus._orders import Order, Point, PointRef
from tca_bus._protocol import Constraint, Outcome, SubmitTask, TaskState, TaskStatus
from tca_bus.tasktree import (
    Abandoned,
    Alarmed,
    Attached,
    CaughtFailure,
    Constrained,
    Deregistered,
    Detached,
    Dispatched,
    HandlerLost,
    HandlerMissing,
    KillRequested,
    Prepared,
    Prioritized,
    RecordedEvent,
    Registered,
    Released,
    Reported,
    Resumed,
    Retried,
    Role,
    Submitted,
    Suspended,
    Taken,
    Triggered,
    UncaughtFailure,
)


@dataclass(frozen=True, slots=True)
class NodeFacts:
    """What is known of the node that an event is about, whatever the event.

    ``was_held`` says that it waited for a constraint when it came, ``monitor`` is the kind of a
    monitor, ``nodes`` maps the ids that the event may name to nodes.
    """

    node: NodeRef
    task_class: str = "goal"
    sender: str = "*"
    parent: str | None = None
    was_held: bool = False
    monitor: str | None = None
    nodes: Mapping[str, NodeRef] = field(default_factory=dict)

    @property
    def word(self) -> MessageWord:
        """Its class, as TCA writes it."""
        return "PMonitor" if self.monitor == "point" else _WORDS.get(self.task_class, "Goal")

    @property
    def parent_number(self) -> int | None:
        """The number of its parent in the log."""
        return self.named(self.parent).number if self.parent else None

    @property
    def resource(self) -> str:
        """Where it waits for a handler."""
        return f"Resource {self.node.name}"

    def named(self, id: str) -> NodeRef:
        """The node with an id; one that the history does not know goes by that."""
        return self.nodes.get(id) or NodeRef(name=id)


@dataclass(frozen=True, slots=True)
class Told:
    """An event in words: one for scripts, a sentence for people, and the lines of TCA's log."""

    event: str
    text: str = ""
    statements: tuple[Statement, ...] = ()


_WORDS: dict[str, MessageWord] = {
    "goal": "Goal",
    "command": "Command",
    "exception": "Exception",
    "monitor": "IMonitor",
}

_POINTS: dict[Point, tuple[Literal["Start", "End"], IntervalWord]] = {
    Point.START_HANDLING: ("Start", "Handling"),
    Point.END_HANDLING: ("End", "Handling"),
    Point.START_PLANNING: ("Start", "Planning"),
    Point.END_PLANNING: ("End", "Planning"),
    Point.START_ACHIEVING: ("Start", "Achievement"),
    Point.END_ACHIEVING: ("End", "Achievement"),
}

_SEQUENTIAL: dict[Constraint, ConstraintWord] = {
    Constraint.SEQ_ACH: "SEQUENTIAL ACHIEVEMENT",
    Constraint.SEQ_PLANNING: "SEQUENTIAL PLANNING",
}

_OWN: dict[Constraint, ConstraintWord] = {
    Constraint.PLAN_FIRST: "PLAN FIRST",
    Constraint.DELAY_PLANNING: "DELAY PLANNING",
}


def _remarked(event: str, text: str) -> Told:
    """Something that TCA's log has no words for."""
    return Told(event, text, (Remark(text=f"{event}: {text}"),))


def _submitted(event: Submitted, facts: NodeFacts) -> Told:
    came = MessagePassed(
        word=facts.word,
        node=facts.node,
        source=facts.sender,
        parent=facts.parent_number,
        destination=facts.resource,
        status="Inactive" if facts.was_held else "Pending",
    )
    constraints = _constraints(event.task, event.previous, facts)
    return Told("submitted", _origin_words(event), (came, *constraints))


def _origin_words(event: Submitted) -> str:
    task = event.task
    below = f", below {task.parent}" if task.parent else ""
    role = "" if event.origin.role is Role.STEP else f", as {event.origin.role} of {task.parent}"
    return f"{task.task_class} from {task.sender}{role or below}"


def _constraints(task: SubmitTask, previous: str | None, facts: NodeFacts) -> Iterator[Statement]:
    for flag in Constraint(task.constraints):
        if flag in _OWN:
            yield ConstraintAdded(constraint=_OWN[flag], node=facts.node)
        elif flag in _SEQUENTIAL and previous and previous in facts.nodes:
            before = facts.named(previous)
            yield ConstraintAdded(constraint=_SEQUENTIAL[flag], node=facts.node, previous=before)
    for order in task.orders:
        yield from _ordered(order, facts)


def _ordered(order: Order, facts: NodeFacts) -> Iterator[Statement]:
    """A constraint between points; what TCA has no words for in a remark."""
    if order.first is not None:
        first, then = _time_point(order.first, facts), _time_point(order.then, facts)
        yield PointsOrdered(first=first, relation=order.relation, second=then)
    if order.first is None or order.delay:
        yield Remark(text=str(order))


def _time_point(ref: PointRef, facts: NodeFacts) -> TimePoint:
    end, interval = _POINTS[ref.point]
    return TimePoint(end=end, interval=interval, node=facts.named(ref.task))


def _prepared(event: Prepared, _: NodeFacts) -> Told:
    return _remarked("prepared", f"by {event.sender}")


def _constrained(event: Constrained, facts: NodeFacts) -> Told:
    return Told("constrained", str(event.order), tuple(_ordered(event.order, facts)))


def _released(event: Released, _: NodeFacts) -> Told:
    return _remarked("released", f"{event.point.value} of {event.previous}")


def _dispatched(event: Dispatched, facts: NodeFacts) -> Told:
    is_first = event.attempt == 1
    sent = MessagePassed(
        word=facts.word,
        node=facts.node,
        source="ON HOLD" if facts.was_held and is_first else facts.resource,
        destination=event.module,
        status="Sent",
    )
    if is_first:
        return Told("dispatched", f"to {event.module}", (sent,))
    text = f"to {event.module}, try {event.attempt}"
    return Told("dispatched", text, (RetryAsked(node=facts.node), sent))


def _taken(_event: Taken, _: NodeFacts) -> Told:
    return _remarked("started", "its handler has it")


def _reported(event: Reported, facts: NodeFacts) -> Told:
    why = _why(event.failure)
    match event.outcome:
        case Outcome.SUCCESS:
            return Told("handled", why, tuple(_succeeded(event.resolution, facts)))
        case Outcome.FAILURE:
            module = (event.failure.module if event.failure else None) or "*"
            return Told("handler failed", why, _failed(facts, module, why))
        case Outcome.KILLED:
            return Told("handler stopped", why, (Remark(text="its handler stopped"),))


def _succeeded(decided: Resolution | None, facts: NodeFacts) -> Iterator[Statement]:
    """The end of a handler; that of an exception handler has decided something."""
    if decided is not None and decided.action == "bypass":
        yield MessagePassed(word="ByPass", node=facts.node, status="Completed")
        return
    yield Answered(word="Success", node=facts.node)
    if decided is not None:
        of = f" {facts.named(decided.task).name}" if decided.task else ""
        yield Remark(text=f"it decided: {decided.action}{of}")


def _abandoned(_event: Abandoned, _: NodeFacts) -> Told:
    return _remarked("abandoned", "its handler did not stop in time")


def _alarmed(event: Alarmed, _: NodeFacts) -> Told:
    return _remarked("time has come", event.key)


def _suspended(_event: Suspended, _: NodeFacts) -> Told:
    return _remarked("suspended", "and all below it")


def _resumed(_event: Resumed, _: NodeFacts) -> Told:
    return _remarked("resumed", "and all below it")


def _prioritized(event: Prioritized, _: NodeFacts) -> Told:
    return _remarked("prioritized", f"to {event.priority}")


def _retried(_event: Retried, facts: NodeFacts) -> Told:
    return Told("retried", "from the start", (RetryAsked(node=facts.node),))


def _triggered(event: Triggered, facts: NodeFacts) -> Told:
    told = _remarked("triggered", f"for the {event.number}. time")
    if facts.monitor != "demon":
        return told
    fired = DemonFired(
        number=facts.node.number, source=facts.node.name, destination="central", status="Sent"
    )
    return replace(told, statements=(fired,))


def _caught(event: CaughtFailure, _: NodeFacts) -> Told:
    return _remarked("caught", f"by {event.catch.handler}, which is on {event.context}")


def _uncaught(_event: UncaughtFailure, _: NodeFacts) -> Told:
    return _remarked("uncaught", "no exception handler takes the failure")


def _attached(event: Attached, _: NodeFacts) -> Told:
    return _remarked("attached", _attachment_words(event.what))


def _detached(event: Detached, _: NodeFacts) -> Told:
    return _remarked("detached", event.attachment)


def _registered(event: Registered, _: NodeFacts) -> Told:
    return _remarked("registered", f"{_attachment_words(event.what)} on {event.message}")


def _deregistered(event: Deregistered, _: NodeFacts) -> Told:
    return _remarked("deregistered", event.id)


def _attachment_words(what: Attachment) -> str:
    match what:
        case Tap():
            return f"tap {what.id}, {what.condition} to {what.listener.name}"
        case Catch():
            return f"catch {what.id}, {what.exception} by {what.handler}"
        case CleanUp():
            return f"clean-up {what.id}, {what.sending.name}"


def _kill_requested(event: KillRequested, facts: NodeFacts) -> Told:
    below = "what is below it: " if event.only_below else ""
    text = f"{below}{event.reason}"
    if event.only_below:
        return Told("kill requested", text, (Remark(text=f"will be killed: {text}"),))
    awaited = KillAwaited(node=facts.node, situation="when it completes")
    return Told("kill requested", text, (awaited, Remark(text=text)))


def _handler_lost(event: HandlerLost, _: NodeFacts) -> Told:
    return _remarked("handler lost", f"module {event.module} is gone")


def _handler_missing(_event: HandlerMissing, facts: NodeFacts) -> Told:
    text = "no module came to handle it"
    return Told("no handler", text, _failed(facts, "central", text))


Teller = Callable[[Any, NodeFacts], Told]

TELLERS: dict[type[RecordedEvent], Teller] = {
    Submitted: _submitted,
    Released: _released,
    Dispatched: _dispatched,
    Taken: _taken,
    Reported: _reported,
    KillRequested: _kill_requested,
    HandlerLost: _handler_lost,
    HandlerMissing: _handler_missing,
    Prepared: _prepared,
    Constrained: _constrained,
    Abandoned: _abandoned,
    Alarmed: _alarmed,
    Suspended: _suspended,
    Resumed: _resumed,
    Prioritized: _prioritized,
    Retried: _retried,
    Triggered: _triggered,
    CaughtFailure: _caught,
    UncaughtFailure: _uncaught,
    Attached: _attached,
    Detached: _detached,
    Registered: _registered,
    Deregistered: _deregistered,
}
"""What tells of each kind of event."""


def tell_event(event: RecordedEvent, facts: NodeFacts) -> Told:
    """Put an event of a node into words."""
    return TELLERS[type(event)](event, facts)


def tell_end(status: TaskStatus, facts: NodeFacts) -> Told:
    """Put the end of a node into words."""
    seconds = (status.ended or status.created) - status.created
    why = _why(status.failure)
    text = f"after {seconds:.1f} s" + (f"; {why}" if why else "")
    if status.state is TaskState.ACHIEVED:
        done = MessagePassed(word=facts.word, node=facts.node, status="Completed")
        return Told(status.state.value, text, (done,))
    told = (Remark(text=why),) if why else ()
    return Told(status.state.value, text, (NodeKilled(node=facts.node), *told))


def _failed(facts: NodeFacts, module: str, why: str) -> tuple[Statement, ...]:
    failed = Answered(word="Failure", node=facts.node, module=module, parent=facts.parent_number)
    return (failed, Remark(text=why)) if why else (failed,)


def _why(failure: Failure | None) -> str:
    if failure is None:
        return ""
    return failure.text if failure.name == "killed" else failure.sentence()
