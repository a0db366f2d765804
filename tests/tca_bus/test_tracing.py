"""OpenTelemetry: a span for each task, parents as in the tree, handlers' own spans below them."""

from __future__ import annotations

import asyncio
import signal
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st
from opentelemetry.sdk.trace import TracerProvider
from opentelemetry.sdk.trace.export import SimpleSpanProcessor
from opentelemetry.sdk.trace.export.in_memory_span_exporter import InMemorySpanExporter
from opentelemetry.trace import StatusCode
from test_tca_cli import finish, office

from tca_bus import (
    Command,
    ConfigError,
    Failure,
    Goal,
    Inform,
    Module,
    TaskError,
    TaskFailedError,
    TaskStatus,
)
from tca_bus._central import Central
from tca_bus._envelope import Envelope, begin_handling, handled, new_envelope
from tca_bus._span_exporter import SpanExporter, asked_for
from tca_bus._spans import span_of
from tca_bus._trace_context import TraceContext, adopt, child_traceparent, node_context
from tca_bus.testing import bus, eventually

SENT = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01"
CONTEXTS = st.builds(
    TraceContext, st.integers(1, 2**128 - 1), st.integers(1, 2**64 - 1), st.integers(0, 1)
)


class Trip(Goal[str]):
    """Step twice."""


class Step(Command[str]):
    """Do it, or fail."""

    fail: bool = False


class Note(Inform):
    """Note something."""


@given(CONTEXTS)
def test_a_context_is_written_as_the_w3c_has_it(context):
    assert TraceContext.parse(str(context)) == context


@pytest.mark.parametrize(
    "text", [None, "", "00-0-0-01", SENT.upper(), SENT.replace("b7ad6b7169203331", "0" * 16)]
)
def test_what_names_no_span_is_no_context(text):
    assert TraceContext.parse(text) is None


@given(CONTEXTS, st.none() | CONTEXTS)
def test_a_child_is_in_the_trace_of_its_parent(parent, sent):
    found = TraceContext.parse(child_traceparent(str(sent) if sent else None, parent))
    assert found is not None
    assert found.trace_id == parent.trace_id
    own = child_traceparent(str(TraceContext(parent.trace_id, 5)), parent)
    assert TraceContext.parse(own) == TraceContext(parent.trace_id, 5)


def status(**facts) -> TaskStatus:
    values = {
        "id": "t-1",
        "parent": None,
        "name": "go",
        "task_class": "goal",
        "sender": "me",
        "state": "achieved",
        "handling": "handled",
        "planning": "planned",
        "achievement": "achieved",
        "existence": "terminated",
        "handler": "robot",
        "attempt": 1,
        "created": 10.0,
        "started": 10.5,
        "ended": 12.0,
        "sequence": 9,
    }
    return TaskStatus(**{**values, **facts})


def test_a_task_that_ended_is_a_span():
    span = span_of(status(), "xavier")
    assert (span.begin, span.end) == (10_000_000_000, 12_000_000_000)
    assert (span.parent, span.link, span.error) == (None, None, None)
    assert span.attributes["tca.task.id"] == "t-1"
    assert "tca.task.parent" not in span.attributes
    assert [event.name for event in span.events] == ["started"]
    assert span.context == span_of(status(state="killed"), "other").context


def test_a_span_hangs_where_the_node_does():
    top = span_of(status(traceparent=SENT), "r")
    assert str(top.parent) == SENT
    assert top.context.trace_id == top.parent.trace_id
    child = span_of(status(id="t-2", parent="t-1", traceparent=str(top.context)), "r")
    assert (child.parent, child.link) == (top.context, None)
    inner = TraceContext(top.context.trace_id, 77)
    linked = span_of(status(id="t-3", parent="t-1", traceparent=str(inner)), "r")
    assert (linked.parent, linked.link) == (top.context, inner)


def test_failures_and_kills_are_told_apart():
    cause = Failure(name="door_blocked", text="the door is closed")
    failure = Failure(name="child_failed", text="go failed", cause=cause)
    failed = span_of(status(state="failed", failure=failure), "r")
    assert failed.error == failure.sentence()
    told = failed.events[-1]
    assert (told.name, told.attributes["exception.type"]) == ("exception", "child_failed")
    assert "door_blocked: the door is closed" in told.attributes["exception.stacktrace"]
    kill = Failure(name="killed", text="enough")
    killed = span_of(status(state="killed", failure=kill), "r")
    assert (killed.error, killed.events[-1].name) == (None, "killed")


class Collected:
    """An exporter that keeps the spans, by the ids of their tasks."""

    def __init__(self):
        self.memory = InMemorySpanExporter()
        self.exporter = SpanExporter(SimpleSpanProcessor(self.memory), "r")

    def spans(self):
        return {span.attributes["tca.task.id"]: span for span in self.memory.get_finished_spans()}

    @property
    def count(self):
        return len(self.memory.get_finished_spans())


def test_the_sdk_gets_the_span_with_its_own_ids():
    collected = Collected()
    failure = Failure(name="door_blocked", text="the door is closed")
    data = status(id="t-2", parent="t-1", state="failed", failure=failure, traceparent=SENT)
    collected.exporter.export(data)
    collected.exporter.export(status())
    first, second = collected.memory.get_finished_spans()
    assert f"{first.context.trace_id:032x}" == SENT.split("-")[1]
    assert first.context.span_id == node_context("t-2", None).span_id
    assert first.parent.span_id == node_context("t-1", None).span_id
    assert f"{first.links[0].context.span_id:016x}" == SENT.split("-")[2]
    assert first.status.status_code is StatusCode.ERROR
    assert (first.start_time, first.end_time) == (10_000_000_000, 12_000_000_000)
    assert first.events[-1].attributes["exception.message"] == "the door is closed"
    assert second.parent is None
    assert second.context.trace_id == node_context("t-1", None).trace_id
    assert second.resource.attributes["service.name"] == "tca-central"
    collected.exporter.close()


def test_what_is_sent_goes_on_from_what_is_handled():
    def inside():
        begin_handling(Envelope(id="1", traceparent=SENT, task="t-1"))
        return new_envelope("me")

    async def run():
        handler = asyncio.get_running_loop().create_task(as_task(inside))
        return await handler, new_envelope("me")

    within, outside = asyncio.run(run())
    assert (within.traceparent, within.task) == (SENT, "t-1")
    assert (outside.traceparent, outside.task) == (None, None)
    assert handled.get() is None


async def as_task(function):
    return function()


def test_a_bad_context_is_adopted_by_nobody():
    async def run():
        adopt("nonsense")
        return new_envelope("me").traceparent

    assert asyncio.run(run()) is None


def trip_module(options, provider, seen):
    module = Module("robot", options=options)
    tracer = provider.get_tracer("robot")

    @module.handler(Trip)
    async def trip(message, context):
        await module.inform(Note())
        await context.execute(Step(), id="a")
        with tracer.start_as_current_span("own") as span:
            seen["own"] = span
            with pytest.raises(TaskFailedError):
                await (await context.execute(Step(fail=True), id="b")).result(timeout=10.0)
        return "there"

    @module.handler(Step)
    async def step(message, context):
        with tracer.start_as_current_span(f"step {context.id}") as span:
            seen[context.id] = span
            if message.fail:
                raise TaskError("door_blocked", "the door is closed")
        return "done"

    @module.handler(Note)
    async def note(message, context):
        seen["note"] = new_envelope("robot").traceparent

    return module


@pytest.mark.bus
async def test_a_tree_of_tasks_is_a_tree_of_spans_with_those_of_handlers_below(tmp_path):
    collected, seen = Collected(), {}
    async with bus() as options:
        async with (
            Central(options, data=tmp_path, on_end=collected.exporter.export),
            trip_module(options, TracerProvider(shutdown_on_exit=False), seen),
            Module("me", options=options) as me,
        ):
            await me.wait_for(Trip, Note, "tca.submit", timeout=10.0)
            handle = await me.expand(Trip(), id="top")
            assert await handle.result(timeout=10.0) == "there"
            await eventually(lambda: len(collected.spans()) == 3)
            await eventually(lambda: "note" in seen)
        spans = collected.spans()
        top = spans["top"].context
        assert spans["top"].parent is None
        for id in ("a", "b"):
            assert spans[id].parent.span_id == top.span_id
            assert spans[id].context.trace_id == top.trace_id
            assert seen[id].parent.span_id == spans[id].context.span_id
            assert seen[id].context.trace_id == top.trace_id
        assert seen["own"].parent.span_id == top.span_id
        assert spans["b"].links[0].context.span_id == seen["own"].context.span_id
        assert spans["b"].status.status_code is StatusCode.ERROR
        assert seen["note"] == f"00-{top.trace_id:032x}-{top.span_id:016x}-01"

        before = collected.count
        async with (
            Central(options, data=tmp_path, on_end=collected.exporter.export),
            trip_module(options, TracerProvider(shutdown_on_exit=False), seen),
            Module("me", options=options) as me,
        ):
            await me.wait_for(Step, "tca.submit", timeout=10.0)
            again = await me.expand(Trip(), id="top")
            assert await again.result(timeout=10.0) == "there"
            await (await me.execute(Step(), id="c")).result(timeout=10.0)
            await eventually(lambda: "c" in collected.spans())
    assert collected.count == before + 1


@pytest.mark.bus
async def test_a_central_that_is_started_again_exports_no_span_twice(tmp_path):
    collected, may_end = Collected(), asyncio.Event()
    async with bus() as options:
        module = Module("robot", options=options)

        @module.handler(Trip)
        async def trip(message, context):
            await context.execute(Step(), id="a")
            await may_end.wait()
            return "there"

        @module.handler(Step)
        async def step(message, context):
            return "done"

        def started():
            return Central(options, data=tmp_path, on_end=collected.exporter.export)

        async with module, Module("me", options=options) as me:
            async with started():
                await me.wait_for(Trip, "tca.submit", timeout=10.0)
                handle = await me.expand(Trip(), id="top")
                await eventually(lambda: "a" in collected.spans())
            async with started():
                may_end.set()
                assert await handle.result(timeout=20.0) == "there"
                await eventually(lambda: "top" in collected.spans())
    assert collected.count == 2


@pytest.mark.bus
async def test_a_top_level_task_is_below_the_span_that_it_was_sent_from():
    collected, seen = Collected(), {}
    provider = TracerProvider(shutdown_on_exit=False)
    async with (
        bus() as options,
        Central(options, on_end=collected.exporter.export),
        trip_module(options, provider, seen),
        Module("me", options=options) as me,
    ):
        await me.wait_for(Step, "tca.submit", timeout=10.0)
        with provider.get_tracer("me").start_as_current_span("request") as request:
            await (await me.execute(Step(), id="c")).result(timeout=10.0)
        await eventually(lambda: "c" in collected.spans())
    assert collected.spans()["c"].parent.span_id == request.get_span_context().span_id
    assert seen["c"].context.trace_id == request.get_span_context().trace_id


@pytest.mark.parametrize(
    ("environ", "name"),
    [
        ({}, None),
        ({"OTEL_TRACES_EXPORTER": "none", "OTEL_EXPORTER_OTLP_ENDPOINT": "http://x"}, None),
        ({"OTEL_TRACES_EXPORTER": "otlp", "OTEL_SDK_DISABLED": "true"}, None),
        ({"OTEL_TRACES_EXPORTER": "console"}, "console"),
        ({"OTEL_EXPORTER_OTLP_ENDPOINT": "http://x"}, "otlp_proto_http"),
        (
            {"OTEL_TRACES_EXPORTER": "otlp", "OTEL_EXPORTER_OTLP_PROTOCOL": "grpc"},
            "otlp_proto_grpc",
        ),
    ],
)
def test_the_environment_says_whether_and_how(environ, name):
    assert asked_for(environ) == name


def test_a_protocol_that_is_none_is_refused():
    environ = {"OTEL_TRACES_EXPORTER": "otlp", "OTEL_EXPORTER_OTLP_PROTOCOL": "pigeon"}
    with pytest.raises(ConfigError, match="OTEL_EXPORTER_OTLP_PROTOCOL is 'pigeon'"):
        asked_for(environ)


@pytest.mark.process
async def test_nothing_of_opentelemetry_is_loaded_when_nobody_asks_for_it():
    code = (
        "import sys, tca_bus, tca_bus.cli.tca, tca_bus._central;"
        "print([name for name in sys.modules if name.startswith('opentelemetry')])"
    )
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-c", code, stdout=asyncio.subprocess.PIPE
    )
    out, _ = await process.communicate()
    assert out.decode().strip() == "[]"


@pytest.mark.bus
@pytest.mark.process
async def test_central_exports_as_the_environment_says():
    async with office() as here:
        elsewhere = {"TCA_REALM": "elsewhere"}
        unknown = await here.tca("central", **elsewhere, OTEL_TRACES_EXPORTER="pigeon")
        assert unknown.code == 2
        assert "pip install 'rogue-on-xavier[otel]'" in unknown.err
        process = await here.start("central", **elsewhere, OTEL_TRACES_EXPORTER="console")
        there = here.options.model_copy(update={"realm": "elsewhere"})
        async with (
            trip_module(there, TracerProvider(shutdown_on_exit=False), {}),
            Module("me", options=there) as me,
        ):
            await me.wait_for(Step, "tca.submit", timeout=30.0)
            await (await me.execute(Step(), id="seen-1")).result(timeout=10.0)
        process.send_signal(signal.SIGTERM)
        ran = await finish(process)
    assert ran.code == 0, ran.err
    assert '"tca.task.id": "seen-1"' in ran.out
