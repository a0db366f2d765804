"""W3C trace context: which span a message or a task was sent from.

A task's node is a span whose ids follow from the ids of the tasks, so that whoever handles the
task can name that span, and a central that was started again names it the same.
"""

from __future__ import annotations

import hashlib
import re
import sys
from dataclasses import dataclass
from typing import Self

TRACEPARENT_PATTERN = r"^[0-9a-f]{2}-[0-9a-f]{32}-[0-9a-f]{16}-[0-9a-f]{2}$"

SAMPLED = 1
"""The flag that says that the spans of a trace are kept."""

API = "opentelemetry.trace"
"""Looked up among the modules that the program has loaded itself, and never imported here."""


@dataclass(frozen=True, slots=True)
class TraceContext:
    """A span, as others refer to it."""

    trace_id: int
    span_id: int
    flags: int = SAMPLED

    @classmethod
    def parse(cls, text: str | None) -> Self | None:
        """Read a ``traceparent``; None when there is none, or none that names a span."""
        if text is None or not re.match(TRACEPARENT_PATTERN, text):
            return None
        _, trace, span, flags = text.split("-")
        if not int(trace, 16) or not int(span, 16):
            return None
        return cls(int(trace, 16), int(span, 16), int(flags, 16))

    def __str__(self) -> str:
        return f"00-{self.trace_id:032x}-{self.span_id:016x}-{self.flags:02x}"


def node_context(task: str, sent_from: str | None) -> TraceContext:
    """The span of a task's node; ``sent_from`` is the ``traceparent`` that it was sent with."""
    sent = TraceContext.parse(sent_from)
    digest = hashlib.sha256(task.encode()).digest()
    trace_id = sent.trace_id if sent else int.from_bytes(digest[:16])
    flags = sent.flags if sent else SAMPLED
    return TraceContext(trace_id, int.from_bytes(digest[16:24]), flags)


def child_traceparent(sent_from: str | None, parent: TraceContext) -> str:
    """What a task below ``parent`` counts as sent from: always a span of its parent's trace."""
    sent = TraceContext.parse(sent_from)
    return str(sent if sent and sent.trace_id == parent.trace_id else parent)


def active_traceparent() -> str | None:
    """The span that is active in this program, if it uses OpenTelemetry."""
    api = sys.modules.get(API)
    if api is None:
        return None
    context = api.get_current_span().get_span_context()
    if not context.is_valid:
        return None
    return str(TraceContext(context.trace_id, context.span_id, context.trace_flags))


def adopt(traceparent: str | None) -> None:
    """Make the span that a message was sent from the parent of what this program does for it."""
    api = sys.modules.get(API)
    sent = TraceContext.parse(traceparent)
    if api is None or sent is None:
        return
    from opentelemetry import context  # noqa: PLC0415 - the program has loaded it already

    remote = api.SpanContext(
        sent.trace_id, sent.span_id, is_remote=True, trace_flags=api.TraceFlags(sent.flags)
    )
    context.attach(api.set_span_in_context(api.NonRecordingSpan(remote), context.Context()))
