"""Exports the spans of tasks by OpenTelemetry, when its environment variables ask for it.

``OTEL_TRACES_EXPORTER`` names the exporter (``otlp`` when only an endpoint is set), the others
are those of OpenTelemetry's SDK; see its documentation. Nothing of it is loaded otherwise.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any

from tca_bus._errors import ConfigError
from tca_bus._protocol import TaskStatus
from tca_bus._spans import SpanData, span_of
from tca_bus._trace_context import TraceContext

if TYPE_CHECKING:
    from opentelemetry.sdk.trace import SpanProcessor, TracerProvider

logger = logging.getLogger(__name__)

SERVICE = "tca-central"
"""Name of the service, unless ``OTEL_SERVICE_NAME`` gives another."""

EXTRA = "rogue-on-xavier[otel]"

ENDPOINTS = ("OTEL_EXPORTER_OTLP_ENDPOINT", "OTEL_EXPORTER_OTLP_TRACES_ENDPOINT")
PROTOCOLS = ("OTEL_EXPORTER_OTLP_TRACES_PROTOCOL", "OTEL_EXPORTER_OTLP_PROTOCOL")
OTLP = {"http/protobuf": "otlp_proto_http", "grpc": "otlp_proto_grpc"}


class SpanExporter:
    """Hands the span of each task that ends to OpenTelemetry's SDK.

    Exporting goes on in a thread of the SDK; `close` waits for it.
    """

    def __init__(self, processor: SpanProcessor, realm: str) -> None:
        self._realm = realm
        self._ids = _PlannedIds()
        self._provider = _provider(self._ids)
        self._provider.add_span_processor(processor)
        self._tracer = self._provider.get_tracer("tca_bus")

    def export(self, status: TaskStatus) -> None:
        """Export the span of a task that has ended."""
        self._export(span_of(status, self._realm))

    def close(self) -> None:
        """Export what is left."""
        self._provider.shutdown()

    def _export(self, data: SpanData) -> None:
        from opentelemetry.trace import Link, Status, StatusCode  # noqa: PLC0415 - optional

        self._ids.context = data.context
        span = self._tracer.start_span(
            data.name,
            context=_parent(data.parent),
            attributes=data.attributes,
            links=[Link(_span_context(data.link))] if data.link else [],
            start_time=data.begin,
        )
        for event in data.events:
            span.add_event(event.name, event.attributes, event.time)
        if data.error is not None:
            span.set_status(Status(StatusCode.ERROR, data.error))
        span.end(data.end)


class _PlannedIds:
    """Gives the SDK the ids that the next span has to have."""

    context = TraceContext(0, 0)

    def generate_span_id(self) -> int:
        """The id of the span."""
        return self.context.span_id

    def generate_trace_id(self) -> int:
        """The id of its trace."""
        return self.context.trace_id

    def is_trace_id_random(self) -> bool:
        """Whether the ids come from chance: they are digests, which is as good."""
        return True


def asked_for(environ: Mapping[str, str] = os.environ) -> str | None:
    """The exporter that the environment names, None when it wants none."""
    if environ.get("OTEL_SDK_DISABLED", "").strip().lower() == "true":
        return None
    named = environ.get("OTEL_TRACES_EXPORTER", "").strip()
    if not named and any(environ.get(name) for name in ENDPOINTS):
        named = "otlp"
    if named in {"", "none"}:
        return None
    if named != "otlp":
        return named
    protocol = next((environ[name] for name in PROTOCOLS if environ.get(name)), "http/protobuf")
    if protocol not in OTLP:
        raise ConfigError(PROTOCOLS[1], protocol, f"one of {', '.join(OTLP)}")
    return OTLP[protocol]


@contextmanager
def spans_from_environment(realm: str) -> Iterator[SpanExporter | None]:
    """The exporter that the environment asks for, open until the block ends.

    Raises:
        ConfigError: It asks for one that is not installed.
    """
    name = asked_for()
    if name is None:
        yield None
        return
    exporter = SpanExporter(_batches(name), realm)
    logger.info("exporting a span for each task by %s", name)
    try:
        yield exporter
    finally:
        exporter.close()


def _batches(name: str) -> SpanProcessor:
    known = {entry.name: entry for entry in entry_points(group="opentelemetry_traces_exporter")}
    if name not in known:
        there = ", ".join(sorted(known)) or "none is installed"
        expected = f"an exporter that is installed ({there}); pip install '{EXTRA}'"
        raise ConfigError("OTEL_TRACES_EXPORTER", name, expected)
    try:
        sdk = import_module("opentelemetry.sdk.trace.export")
        exporter = known[name].load()()
    except ImportError as error:
        expected = f"an exporter that can be loaded ({error}); pip install '{EXTRA}'"
        raise ConfigError("OTEL_TRACES_EXPORTER", name, expected) from error
    processor: SpanProcessor = sdk.BatchSpanProcessor(exporter)
    return processor


def _provider(ids: Any) -> TracerProvider:
    from opentelemetry.sdk.resources import Resource  # noqa: PLC0415 - optional
    from opentelemetry.sdk.trace import TracerProvider  # noqa: PLC0415 - same

    name = os.environ.get("OTEL_SERVICE_NAME") or SERVICE
    resource = Resource.create({"service.name": name})
    return TracerProvider(id_generator=ids, resource=resource, shutdown_on_exit=False)


def _parent(context: TraceContext | None) -> Any:
    from opentelemetry import context as contexts  # noqa: PLC0415 - optional
    from opentelemetry import trace  # noqa: PLC0415 - same

    empty = contexts.Context()
    if context is None:
        return empty
    return trace.set_span_in_context(trace.NonRecordingSpan(_span_context(context)), empty)


def _span_context(context: TraceContext) -> Any:
    from opentelemetry.trace import SpanContext, TraceFlags  # noqa: PLC0415 - optional

    return SpanContext(
        context.trace_id, context.span_id, is_remote=True, trace_flags=TraceFlags(context.flags)
    )
