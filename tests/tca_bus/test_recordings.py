"""Recordings: every message as it was, whatever becomes of the recorder or of the file."""

from __future__ import annotations

import asyncio
import io
import json
import signal
import struct

import pytest
import zenoh
from central_robot import Arrive, Drive, Ring
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import Writer
from pydantic import BaseModel
from test_tca_cli import finish, office

from tca_bus import (
    Broadcast,
    ConfigError,
    Failure,
    Module,
    RecordStream,
    TaskStatus,
    UnreadableError,
)
from tca_bus._json_views import guessed_schema, json_view, plain_schema
from tca_bus._recorder import Backlog, Recorder
from tca_bus._recording import ENVELOPES, Passed, RecordingWriter
from tca_bus._recording_reader import RecordingError, RecordingReader, read_info
from tca_bus._replayer import Remap, Replayer, parse_speed
from tca_bus._selection import Selection
from tca_bus._wire import Payload, encode_message
from tca_bus.arrays import Float32Array
from tca_bus.testing import bus, eventually

CHUNKS = st.from_regex(r"[a-z][a-z0-9.]{0,5}", fullmatch=True)
KEYS = st.lists(CHUNKS, min_size=1, max_size=4).map("/".join)
JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4), inner),
    max_leaves=8,
)
PAYLOADS = st.builds(
    Payload,
    st.binary(max_size=40) | JSON.map(lambda value: json.dumps(value).encode()),
    st.sampled_from(["application/json", "application/json;a@1", "zenoh/bytes", ""]),
)
TIMES = st.integers(0, 2**63)
MESSAGES = st.lists(
    st.builds(
        Passed,
        key=KEYS,
        payload=PAYLOADS,
        attachment=st.none() | st.binary(min_size=1, max_size=20) | st.just(b'{"id":"1"}'),
        published=TIMES,
        seen=TIMES,
        is_gone=st.booleans(),
    ),
    min_size=1,
    max_size=8,
)


class Scan(Broadcast):
    """Ranges all around, in metres."""

    ranges: Float32Array


def write(messages, *, finished=True, schemas=None):
    stream = io.BytesIO()
    writer = RecordingWriter(stream, "r", schemas or {})
    for passed in messages:
        writer.write(passed)
        writer.flush()
    if finished:
        writer.finish(dropped=3)
    return stream.getvalue()


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("recordings") / "one.mcap"


def read(path, data):
    path.write_bytes(data)
    with RecordingReader(path) as reader:
        return list(reader), reader


@settings(deadline=None, max_examples=60)
@given(MESSAGES)
def test_what_was_written_is_read_as_it_was(path, messages):
    found, reader = read(path, write(messages))
    assert found == messages
    assert (reader.realm, reader.is_finished, reader.dropped) == ("r", True, 3)


@settings(deadline=None, max_examples=60)
@given(MESSAGES, st.data())
def test_of_a_recording_cut_off_anywhere_the_beginning_is_left(path, messages, data):
    whole, begun = write(messages, finished=False), len(write([], finished=False))
    cut = data.draw(st.integers(begun, len(whole)))
    found, reader = read(path, whole[:cut])
    assert found == messages[: len(found)]
    assert not reader.is_finished
    if cut == len(whole):
        assert found == messages


@settings(deadline=None, max_examples=60)
@given(MESSAGES, st.data())
def test_a_damaged_recording_is_told_and_never_misread(path, messages, data):
    whole = bytearray(write(messages))
    place = data.draw(st.integers(0, len(whole) - 1))
    whole[place] ^= data.draw(st.integers(1, 255))
    try:
        found, _ = read(path, bytes(whole))
    except (ConfigError, RecordingError):
        return
    assert found == messages[: len(found)]


def foreign():
    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start(profile="ros2")
    writer.finish()
    return stream.getvalue()


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "expected a recording made by 'tca record'"),
        (b"hello, world, this is no recording", "expected a recording made by 'tca record'"),
        (foreign(), "not an MCAP file with profile 'ros2'"),
        (None, "No such file"),
    ],
)
def test_a_file_that_is_no_recording_is_refused(tmp_path, data, problem):
    path = tmp_path / "other.mcap"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(ConfigError, match="recording is ") as caught:
        read_info(path)
    assert problem in str(caught.value)


def test_damage_is_told_with_what_comes_before_it(tmp_path):
    path = tmp_path / "one.mcap"
    one = Passed("broadcast/a/me", Payload(b"{}", "application/json"), None, 1, 2)
    whole = bytearray(write([one, one, one]))
    place = whole.rindex(struct.pack("<I", 0xFD2FB528), 0, whole.rindex(b"tca.end"))
    whole[place + 12] ^= 0xFF
    path.write_bytes(bytes(whole))
    with pytest.raises(RecordingError, match="damaged after 2 messages"):
        read_info(path)


def own_mcap(path, finish):
    """An MCAP file of any recorder, whose last metadata ``finish`` writes."""
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="own")
        writer.add_metadata("about", {"who": "me"})
        channel = writer.register_channel("topic", "json", 0)
        writer.add_message(channel, 0, b"{}", 0)
        finish(writer)
        writer.finish()
    return path


def test_records_of_any_recorder_are_streamed_to_its_end(tmp_path):
    path = own_mcap(tmp_path / "own.mcap", lambda it: it.add_metadata("end", {"dropped": "7"}))
    with RecordStream(path, end="end") as records:
        assert (records.profile, records.is_finished) == ("own", False)
        about, message = records
        assert about.metadata == {"who": "me"}
        assert records.channels[message.channel_id].topic == "topic"
        assert (records.is_finished, records.dropped) == (True, 7)


def test_an_end_that_says_nothing_of_use_is_told(tmp_path):
    path = own_mcap(tmp_path / "own.mcap", lambda it: it.add_metadata("end", {"dropped": "few"}))
    with (
        pytest.raises(UnreadableError, match="dropped is 'few', expected a number"),
        RecordStream(path, end="end") as records,
    ):
        list(records)


def test_viewers_find_json_and_schemas(tmp_path):
    scan = encode_message(Scan(ranges=[1.0, float("nan"), 2.5]))
    status = {"type": "object", "properties": {"state": {"type": "string"}}}
    messages = [
        Passed("broadcast/scan/robot", scan, None, 1, 1),
        Passed("task/me/t-1", Payload(b'{"state":"x"}', "application/json;s@1"), None, 2, 2),
        Passed("task/me/t-2", Payload(b'{"state":"y"}', "application/json;s@1"), None, 3, 3),
        Passed("inform/raw/me", Payload(b"\x00\x01", "zenoh/bytes"), None, 4, 4),
    ]
    data = write(messages, schemas={"scan@1": Scan.model_json_schema(), "s@1": status})
    seen = {}
    for schema, channel, message in make_reader(io.BytesIO(data)).iter_messages():
        if channel.topic != ENVELOPES:
            seen.setdefault(channel.topic, []).append((schema, channel, message.data))
    (schema, channel, view) = seen["broadcast/scan/robot"][0]
    assert (channel.message_encoding, schema.encoding) == ("json", "jsonschema")
    assert json.loads(view) == {"ranges": [1.0, None, 2.5]}
    assert json.loads(schema.data)["properties"]["ranges"]["items"] == {"type": "number"}
    assert [view for _, _, view in seen["task/me"]] == [b'{"state":"x"}', b'{"state":"y"}']
    assert seen["inform/raw/me"][0][:1] == (None,)
    path = tmp_path / "views.mcap"
    found, _ = read(path, data)
    assert found == messages
    info = read_info(path)
    assert info.topics["task/me", "s@1"] == 2
    assert info.is_finished


class Branch(BaseModel):
    name: str
    left: Branch | None = None
    size: float | int | None = None


def test_schemas_are_written_out_for_viewers_that_follow_no_references():
    plain = plain_schema(Branch.model_json_schema(), "branch@1")
    assert plain["properties"]["name"]["type"] == "string"
    assert plain["properties"]["left"]["type"] == "object"
    for schema in (plain, plain_schema(TaskStatus.model_json_schema(), "status")):
        text = json.dumps(schema)
        assert "$ref" not in text
        assert "anyOf" not in text
        assert schema["type"] == "object"


@given(JSON)
def test_a_view_is_strict_json_and_keeps_what_is(value):
    view = json_view(Payload(json.dumps(value).encode(), "application/json"))
    strict = json.loads(view, parse_constant=pytest.fail)
    if "NaN" not in json.dumps(value) and "Infinity" not in json.dumps(value):
        assert strict == value
    assert guessed_schema(view, "x")["title"] == "x"


def test_what_is_no_json_has_no_view():
    assert json_view(Payload(b"\xff", "application/json")) is None
    assert json_view(Payload(b"\x01", "application/x-tca-frame;scan@1")) is None
    deep = b"[" * 100_000
    assert json_view(Payload(deep, "application/json")) is None


def test_keys_are_selected_as_users_name_them():
    def includes(words, key):
        return Selection.parse(words).includes(key)

    assert includes([], "anything/at/all")
    assert includes(["scan"], "broadcast/scan/robot")
    assert includes(["scan"], "inform/scan/robot")
    assert not includes(["scan"], "broadcast/scanner/robot")
    assert includes(["presence"], "presence/robot/1/host/2/-")
    assert includes(["task/me/*"], "task/me/t-1")
    assert not includes(["task/me/*"], "task/you/t-1")
    both = Selection.parse(["broadcast/**", "scan", "broadcast/**"])
    assert both.expressions == ("broadcast/**", "inform/scan/*")
    for word, problem in [("query/**", "no query"), ("a b", "a message's name"), ("a//b", "key")]:
        with pytest.raises(ConfigError, match=problem):
            Selection.parse([word])


def test_keys_are_remapped_by_their_beginnings():
    remap = Remap.parse(["broadcast/scan=broadcast/old/scan", "task=past"])
    assert remap.apply("broadcast/scan/robot") == "broadcast/old/scan/robot"
    assert remap.apply("broadcast/scanner/robot") == "broadcast/scanner/robot"
    assert remap.apply("task/me/t") == "past/me/t"
    for word in ["scan", "=x", "a=*", "a=", "a=b//c"]:
        with pytest.raises(ConfigError, match="OLD=NEW"):
            Remap.parse([word])


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "fast"])
def test_a_speed_that_is_none_is_refused(text):
    with pytest.raises(ConfigError, match="--speed"):
        parse_speed(text)


def test_what_does_not_fit_is_dropped_and_counted():
    one = Passed("a", Payload(b"12345", ""), None, 0, 0)
    few = Backlog(most=2)
    small = Backlog(most_bytes=12)
    for backlog in (few, small):
        for _ in range(5):
            backlog.push(one)
        assert (len(backlog.take()), backlog.dropped) == (2, 3)
        backlog.push(one)
        assert backlog.take() == [one]
    assert Backlog().take() == []


@pytest.mark.bus
async def test_a_replay_is_what_was_recorded(tmp_path):
    path = tmp_path / "bus.mcap"
    async with bus() as options:
        async with Module("tool", options=options) as tool, Module("me", options=options) as me:
            with path.open("wb") as stream:
                recorder = Recorder(tool, path, stream, Selection())
                recording = asyncio.create_task(recorder.run())
                await eventually(lambda: recorder._boxes)
                await eventually(lambda: has_recorded(recorder, me))
                await me.broadcast(Scan(ranges=[0.1, 0.2]))
                await eventually(lambda: recorder.writer._channels.keys() >= scans())
                recording.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await recording
        with RecordingReader(path) as reader:
            messages = [passed for passed in reader if passed.key.startswith("broadcast")]
            assert reader.is_finished
        (scan,) = [passed for passed in messages if "scan" in passed.key]
        assert scan.payload == encode_message(Scan(ranges=[0.1, 0.2]))
        assert json.loads(scan.attachment)["sender"] == me.incarnation
        assert abs(scan.published - scan.seen) < 60e9

        there = options.model_copy(update={"realm": "elsewhere"})
        async with Module("tool", options=there) as tool, Module("you", options=there) as you:
            async with you.subscribe(Scan) as seen:
                raw = []
                key = "elsewhere/broadcast/**"
                listener = you.core.session.zenoh.declare_subscriber(
                    key, zenoh.handlers.Callback(lambda sample: raw.append(attachment(sample)))
                )
                await you.core.session.settle(you.core.keys.all_presence())
                replayer = Replayer(tool, Selection.parse(["scan"]), speed=1000.0)
                await replayer.run(messages)
                assert list((await seen.get()).ranges) == [pytest.approx(0.1), pytest.approx(0.2)]
                await eventually(lambda: ("elsewhere/broadcast/scan/me", scan.attachment) in raw)
                listener.undeclare()
            assert replayer.sent == 1


def scans():
    return {("broadcast/scan/me", "application/x-tca-frame;scan@1")}


def attachment(sample):
    return str(sample.key_expr), sample.attachment.to_bytes() if sample.attachment else None


async def has_recorded(recorder, me):
    """Whether something that is sent now is recorded."""
    await me.broadcast_json("probe", {})
    return any(topic == "broadcast/probe/me" for topic, _ in recorder.writer._channels)


@pytest.mark.bus
async def test_the_timing_is_kept_and_recorded_modules_may_appear():
    async with bus() as options, Module("tool", options=options) as tool:
        gone = {"key": "presence/ghost/0001/host/7/go", "attachment": None, "published": 0}
        token = Payload(b"{}", "application/json")
        note = Passed("broadcast/a/me", token, None, 0, 10**9)
        recording = [
            Passed(payload=token, seen=0, **gone),
            note,
            Passed(payload=token, seen=2 * 10**9, is_gone=True, **gone),
        ]
        names = []

        class Watched(Replayer):
            async def _reach(self, due):
                dues.append(due)
                await eventually(lambda: self.sent < 1 or ghost())

        def ghost():
            names[:] = [module.name for module in tool.modules()]
            return "ghost" in names

        dues = []
        await Watched(tool, speed=0.5, with_presence=True).run(recording)
        assert [due - dues[0] for due in dues] == pytest.approx([0.0, 2.0, 4.0], abs=0.5)
        await eventually(lambda: not ghost())
        hidden = Replayer(tool, speed=float("inf"), skip=0.5)
        await hidden.run(recording)
        assert hidden.sent == 1


@pytest.mark.slow
@pytest.mark.bus
@pytest.mark.process
async def test_the_command_line_records_and_replays(tmp_path):
    path = tmp_path / "office.mcap"
    async with office() as here:
        process = await here.start("record", str(path))
        assert b"Ctrl-C ends it" in await process.stderr.readline()
        await eventually(lambda: is_written(here, path))
        handle = await here.me.execute(Drive(to="x"), id="d1")
        await here.me.inform(Arrive())
        await handle.result(timeout=10.0)
        await eventually(lambda: topics(path).get("task/me", 0) >= 2)
        process.send_signal(signal.SIGINT)
        ran = await finish(process)
        assert ran.code == 0, ran.err
        assert " 0 dropped" in ran.out
        info = (await here.tca("replay", str(path), "--info", "--json")).json
        assert info["finished"]
        assert {"presence", "task/me", "inform/arrive/me"} <= {t["topic"] for t in info["topics"]}
        table = await here.tca("replay", str(path), "--info")
        assert "tca.status@1" in table.out
        async with here.me.subscribe(Ring):
            replayed = await here.tca(
                *("replay", str(path), "--speed", "max", "--only", "ring", "--json")
            )
        assert replayed.json["messages"] >= 1
        await refused(here, path)


async def refused(here, path):
    again, speed, other = await asyncio.gather(
        here.tca("record", str(path)),
        here.tca("replay", str(path), "--speed", "0"),
        here.tca("replay", __file__),
    )
    assert (again.code, speed.code, other.code) == (2, 2, 2)
    assert "--force writes over it" in again.err
    assert "a number above zero, or max" in speed.err
    assert "a recording made by 'tca record'" in other.err


async def is_written(here, path):
    await here.me.inform(Ring(times=1))
    return topics(path).get("inform/ring/me", 0)


def topics(path):
    if not path.exists() or not path.stat().st_size:
        return {}
    return {topic: count for (topic, _), count in read_info(path).topics.items()}


@pytest.mark.bus
@pytest.mark.process
async def test_a_recorder_killed_by_force_leaves_what_it_had(tmp_path):
    path = tmp_path / "cut.mcap"
    async with office() as here:
        process = await here.start("record", str(path), "inform", "task")
        await process.stderr.readline()
        await eventually(lambda: is_written(here, path))
        process.kill()
        await process.wait()
        assert not read_info(path).is_finished
        replayed = await here.tca("replay", str(path), "--speed", "max")
    assert replayed.code == 0
    assert "cut off" in replayed.err


def test_failures_are_told_by_their_own_schema():
    failure = plain_schema(Failure.model_json_schema(), "failure")
    assert failure["properties"]["cause"] == {"type": "object"}
