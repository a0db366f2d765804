"""The end of a task as an OpenTelemetry span: values only, whatever exports them."""

from __future__ import annotations

from dataclasses import dataclass, field

from tca_bus._failure import Failure
from tca_bus._protocol import TaskState, TaskStatus
from tca_bus._trace_context import TraceContext, node_context

Value = str | int | float | bool


@dataclass(frozen=True, slots=True)
class SpanEvent:
    """Something that happened within a span; ``time`` in nanoseconds since the epoch."""

    name: str
    time: int
    attributes: dict[str, Value] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class SpanData:
    """A span; times in nanoseconds since the epoch, ``error`` is None unless it failed.

    ``parent`` is the span of the parent node, or for a top-level task the one that it was sent
    from. ``link`` is the span within the parent's handler that sent it, if it had one.
    """

    context: TraceContext
    parent: TraceContext | None
    link: TraceContext | None
    name: str
    begin: int
    end: int
    error: str | None
    attributes: dict[str, Value]
    events: tuple[SpanEvent, ...]


def span_of(status: TaskStatus, realm: str) -> SpanData:
    """The span of a node that has ended."""
    context = node_context(status.id, status.traceparent)
    sent = TraceContext.parse(status.traceparent)
    parent = sent
    if status.parent is not None:
        parent = node_context(status.parent, str(context))
    failure = status.failure if status.state is TaskState.FAILED else None
    return SpanData(
        context=context,
        parent=parent,
        link=sent if sent != parent else None,
        name=status.name,
        begin=_nanoseconds(status.created),
        end=_nanoseconds(max(status.ended or status.created, status.created)),
        error=failure.sentence() if failure else None,
        attributes=_attributes(status, realm),
        events=tuple(_events(status)),
    )


def _attributes(status: TaskStatus, realm: str) -> dict[str, Value]:
    told: dict[str, Value | None] = {
        "tca.realm": realm,
        "tca.task.id": status.id,
        "tca.task.parent": status.parent,
        "tca.task.class": status.task_class,
        "tca.task.state": status.state.value,
        "tca.task.sender": status.sender,
        "tca.task.handler": status.handler,
        "tca.task.attempts": status.attempt,
        "tca.task.priority": status.priority,
    }
    return {key: value for key, value in told.items() if value is not None}


def _events(status: TaskStatus) -> list[SpanEvent]:
    events = []
    if status.started is not None:
        handler: dict[str, Value] = {"tca.task.handler": status.handler or ""}
        events.append(SpanEvent("started", _nanoseconds(status.started), handler))
    if status.failure is not None:
        is_kill = status.state is TaskState.KILLED
        name = "killed" if is_kill else "exception"
        time = _nanoseconds(status.ended or status.created)
        events.append(SpanEvent(name, time, _failure(status.failure)))
    return events


def _failure(failure: Failure) -> dict[str, Value]:
    """A failure with OpenTelemetry's names for an exception; the causes as its trace."""
    chain = list(failure.chain())
    told: dict[str, Value] = {"exception.type": failure.name, "exception.message": failure.text}
    if len(chain) > 1:
        told["exception.stacktrace"] = "\n".join(f"{one.name}: {one.text}" for one in chain)
    return told


def _nanoseconds(seconds: float) -> int:
    return round(seconds * 1e9)
