"""The task history: what each journalled event says to people, and in TCA's log.

Each kind of event has a teller in `TELLERS`; a new kind needs one there and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from tca_bus._failure import Failure
from tca_bus._log_statements import (
    Answered,
    ConstraintAdded,
    ConstraintWord,
    KillAwaited,
    MessagePassed,
    MessageWord,
    NodeKilled,
    NodeRef,
    Remark,
    Retried,
    Statement,
)
from tca_bus._protocol import Constraint, Outcome, TaskState, TaskStatus
from tca_bus.tasktree import (
    Dispatched,
    HandlerLost,
    HandlerMissing,
    KillRequested,
    RecordedEvent,
    Released,
    Reported,
    Submitted,
    Taken,
)


@dataclass(frozen=True, slots=True)
class NodeFacts:
    """What is known of the node that an event is about, whatever the event.

    ``was_held`` says that it waited for a constraint when it came, ``relatives`` maps the ids
    of its parent and its previous sibling to them.
    """

    node: NodeRef
    task_class: str = "goal"
    sender: str = "*"
    parent: str | None = None
    was_held: bool = False
    relatives: Mapping[str, NodeRef] = field(default_factory=dict)

    @property
    def word(self) -> MessageWord:
        """Its class, as TCA writes it."""
        return _WORDS.get(self.task_class, "Goal")

    @property
    def parent_number(self) -> int | None:
        """The number of its parent in the log."""
        known = self.relatives.get(self.parent) if self.parent else None
        return known.number if known else None

    @property
    def resource(self) -> str:
        """Where it waits for a handler."""
        return f"Resource {self.node.name}"


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
    "interval_monitor": "IMonitor",
    "point_monitor": "PMonitor",
}

_SEQUENTIAL: dict[Constraint, ConstraintWord] = {
    Constraint.SEQ_ACH: "SEQUENTIAL ACHIEVEMENT",
    Constraint.SEQ_PLANNING: "SEQUENTIAL PLANNING",
}

_OWN: dict[Constraint, ConstraintWord] = {
    Constraint.PLAN_FIRST: "PLAN FIRST",
    Constraint.DELAY_PLANNING: "DELAY PLANNING",
}


def _submitted(event: Submitted, facts: NodeFacts) -> Told:
    task = event.task
    below = f", below {task.parent}" if task.parent else ""
    came = MessagePassed(
        word=facts.word,
        node=facts.node,
        source=facts.sender,
        parent=facts.parent_number,
        destination=facts.resource,
        status="Inactive" if facts.was_held else "Pending",
    )
    constraints = _constraints(Constraint(task.constraints), event.previous, facts)
    text = f"{task.task_class} from {task.sender}{below}"
    return Told("submitted", text, (came, *constraints))


def _constraints(
    flags: Constraint, previous: str | None, facts: NodeFacts
) -> Iterator[ConstraintAdded]:
    before = facts.relatives.get(previous) if previous else None
    for flag in flags:
        if flag in _OWN:
            yield ConstraintAdded(constraint=_OWN[flag], node=facts.node)
        elif flag in _SEQUENTIAL and before is not None:
            yield ConstraintAdded(constraint=_SEQUENTIAL[flag], node=facts.node, previous=before)


def _released(event: Released, _: NodeFacts) -> Told:
    text = f"{event.point.value} of {event.previous}"
    return Told("released", text, (Remark(text=f"released by {text}"),))


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
    return Told("dispatched", text, (Retried(node=facts.node), sent))


def _taken(_event: Taken, _: NodeFacts) -> Told:
    return Told("started", "its handler has it", (Remark(text="its handler has it"),))


def _reported(event: Reported, facts: NodeFacts) -> Told:
    why = _why(event.failure)
    match event.outcome:
        case Outcome.SUCCESS:
            return Told("handled", why, (Answered(word="Success", node=facts.node),))
        case Outcome.FAILURE:
            module = (event.failure.module if event.failure else None) or "*"
            return Told("handler failed", why, _failed(facts, module, why))
        case Outcome.KILLED:
            return Told("handler stopped", why, (Remark(text="its handler stopped"),))


def _kill_requested(event: KillRequested, facts: NodeFacts) -> Told:
    below = "what is below it: " if event.only_below else ""
    text = f"{below}{event.reason}"
    if event.only_below:
        return Told("kill requested", text, (Remark(text=f"will be killed: {text}"),))
    awaited = KillAwaited(node=facts.node, situation="when it completes")
    return Told("kill requested", text, (awaited, Remark(text=text)))


def _handler_lost(event: HandlerLost, _: NodeFacts) -> Told:
    text = f"module {event.module} is gone"
    return Told("handler lost", text, (Remark(text=text),))


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
