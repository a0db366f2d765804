"""Recordings of the robot: what is in them, how Foxglove sees them, and files that are none."""

from __future__ import annotations

import io
import json
import math
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_protobuf.decoder import DecoderFactory
from xavier_recordings import PLAN, TICKS, damaged, fresh_state, read, same, things, write

from tca_bus._schema import schema_problems
from xavier_sim.cli._recording import beginning_of
from xavier_sim.messages import (
    SONAR_RING_RADIUS,
    STRIPER_AHEAD,
    Drive,
    Sensors,
    TrueLocation,
)
from xavier_sim.profile import PROFILES
from xavier_sim.recording import Recorder, RecordingFileError, RecordingReader, Tape, decode
from xavier_sim.recording import _recorder as recorder_module
from xavier_sim.recording._heard import Belief
from xavier_sim.running import RobotState, SimClock
from xavier_sim.world import World


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    path = tmp_path_factory.mktemp("recording") / "drive.mcap"
    with path.open("wb") as stream:
        told = write(stream)
    return path, told


def test_what_was_told_comes_back_to_the_bit_and_in_order(recording):
    path, told = recording
    told = [message for message in told if not isinstance(message, Belief)]
    reader, entries = read(path)
    messages = [decode(entry.name, entry.payload) for entry in entries]
    assert len(messages) == len(told)
    assert all(map(same, messages, told))
    order = [(entry.time, entry.sequence) for entry in entries]
    assert order == sorted(set(order))
    assert entries[0].time == 1_000_000_000_000
    assert reader.is_finished
    assert reader.dropped == 3


def test_the_beginning_says_how_things_stood(recording):
    path, _ = recording
    with RecordingReader(path) as reader:
        beginning = reader.beginning
    assert beginning.floor == PLAN
    assert (beginning.seed, beginning.speed, beginning.time) == (1, None, 1000.0)
    assert all(door.open for door in beginning.doors)
    assert len(beginning.doors) == len(PLAN.doors)


def decoded(path):
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for schema, channel, message in reader.iter_messages():
            if channel.message_encoding == "json":
                yield schema, channel.topic, json.loads(message.data)
            else:
                decoder = DecoderFactory().decoder_for(channel.message_encoding, schema)
                yield schema, channel.topic, decoder(message.data)


def assert_foxglove_reads(schema):
    """The rules of its reader of JSON schemas, which refuses a channel that breaks one."""
    assert schema["type"] == "object"
    for field in schema["properties"].values():
        inner = field["items"] if field["type"] == "array" else field
        assert inner["type"] in {"boolean", "integer", "number", "object", "string"}
        if inner["type"] == "object":
            assert_foxglove_reads(inner)


def test_every_channel_has_a_schema_that_its_messages_fit(recording):
    path, _ = recording
    shown = {}
    for schema, topic, message in decoded(path):
        shown[topic] = schema.name
        if schema.encoding == "jsonschema":
            rules = json.loads(schema.data)
            assert_foxglove_reads(rules)
            assert rules["properties"] or topic == "wire/xavierFault"
            assert schema_problems(message, rules) == []
        else:
            assert schema.encoding == "protobuf"
            assert message.DESCRIPTOR.full_name == schema.name
            assert message.ByteSize() > 0
    assert shown == {
        "/beginning": "Beginning",
        "/belief": "BeliefState",
        "/belief/cells": "foxglove.PosesInFrame",
        "/doors": "foxglove.SceneUpdate",
        "/floor": "foxglove.SceneUpdate",
        "/log": "foxglove.Log",
        "/odometry": "foxglove.Odometry",
        "/position": "foxglove.PoseInFrame",
        "/progress": "DriveState",
        "/robot": "foxglove.SceneUpdate",
        "/sonar": "foxglove.SceneUpdate",
        "/striper": "foxglove.LaserScan",
        "/tasks": "TaskStatus",
        "/tf": "foxglove.FrameTransforms",
        "/truth": "foxglove.PoseInFrame",
        "wire/xavierDoorMoved": "xavierDoorMoved",
        "wire/xavierDrive": "xavierDrive",
        "wire/xavierFault": "xavierFault",
        "wire/xavierPlate.reply": "xavierPlate.reply",
        "wire/xavierSensors": "google.protobuf.BytesValue",
        "wire/xavierTrueLocation.reply": "xavierTrueLocation.reply",
    }


def on_topic(path, topic):
    return [message for _, where, message in decoded(path) if where == topic]


def test_cones_lie_where_the_echoes_are(recording):
    path, told = recording
    sensed = [message for message in told if isinstance(message, Sensors)]
    for sensors, update in zip(sensed, on_topic(path, "/sonar"), strict=True):
        fresh = [number for number in range(24) if sensors.sonar_fresh >> number & 1]
        drawn = {int(entity.id[-2:]): entity for entity in update.entities}
        assert sorted(drawn) == [n for n in fresh if math.isfinite(sensors.sonar[n])]
        gone = [int(deletion.id[-2:]) for deletion in update.deletions]
        assert gone == [n for n in fresh if not math.isfinite(sensors.sonar[n])]
        for number, entity in drawn.items():
            apex, *arc = entity.triangles[0].points
            assert math.hypot(apex.x, apex.y) == pytest.approx(SONAR_RING_RADIUS)
            bearing = math.atan2(apex.y, apex.x) % (2 * math.pi)
            assert bearing == pytest.approx(math.radians(15 * number), abs=1e-9)
            reach = [math.dist((apex.x, apex.y), (tip.x, tip.y)) for tip in arc]
            assert reach == pytest.approx([float(sensors.sonar[number])] * len(arc))


@pytest.mark.parametrize(
    ("profile", "sensor", "ahead"), [("hard", "striper", STRIPER_AHEAD), ("modern", "lidar", 0.0)]
)
def test_laser_beams_are_scans(tmp_path, profile, sensor, ahead):
    path, sensed = tmp_path / "beams.mcap", []
    state = RobotState(World(PLAN, 1, PROFILES[profile]), SimClock(1000.0), speed=None)
    with path.open("wb") as stream:
        tape = Tape(stream, beginning_of(state))
        for _ in range(5):
            state.world.step(0.3, 0.2)
            sensed.append(state.sensors())
            tape.sense(sensed[-1], state.true_location())
        tape.finish(dropped=0)
    scans = on_topic(path, f"/{sensor}")
    assert [list(scan.ranges) for scan in scans] == [
        getattr(one, sensor).tolist() for one in sensed
    ]
    assert {scan.pose.position.x for scan in scans} == {ahead}
    assert {scan.start_angle + scan.end_angle for scan in scans} == {0.0}


def test_those_who_stand_about_are_drawn_when_they_move(tmp_path):
    path, seen = tmp_path / "crowd.mcap", []
    state = RobotState(World(PLAN, 1, people=2, carts=1), SimClock(1000.0), speed=None)
    with path.open("wb") as stream:
        tape = Tape(stream, beginning_of(state))
        for _ in range(100):
            state.world.step(0.0, 0.0)
            seen.append(state.standing())
            tape.sense(state.sensors(), state.true_location(), seen[-1])
        tape.finish(dropped=0)
    drawn = {}
    updates = on_topic(path, "/crowd")
    assert len(updates[0].entities) == 3
    for update in updates:
        drawn.update((entity.id, entity.cylinders[0]) for entity in update.entities)
    for number, one in enumerate(seen[-1]):
        cylinder = drawn[f"standing-{number}"]
        assert (cylinder.pose.position.x, cylinder.pose.position.y) == (one.x, one.y)
        assert cylinder.size.x == 2 * one.radius
        assert (cylinder.size.z > 1.5) == one.person
    assert sum(len(update.entities) for update in updates) < 3 * 100, "carts stand still"


def test_the_odometry_frame_of_a_robot_that_began_elsewhere_lies_where_it_began(tmp_path):
    path = tmp_path / "second.mcap"
    world = World(PLAN, 1, robots=("han", "yoda"))
    state = RobotState(world, SimClock(1000.0), speed=None, name="yoda")
    with path.open("wb") as stream:
        tape = Tape(stream, beginning_of(state))
        tape.sense(state.sensors(), state.true_location(), state.standing())
        tape.finish(dropped=0)
    (update,) = on_topic(path, "/tf")
    truth = world.truth("yoda")
    assert composed(*update.transforms[:2]) == pytest.approx((truth.x, truth.y, truth.theta))
    (crowd,) = on_topic(path, "/crowd")
    at = crowd.entities[0].cylinders[0].pose.position
    assert (at.x, at.y) == (world.truth("han").x, world.truth("han").y)


def test_frames_follow_odometry_and_truth(recording):
    path, told = recording
    sensed = [message for message in told if isinstance(message, Sensors)]
    truths = [message for message in told if isinstance(message, TrueLocation)]
    updates = on_topic(path, "/tf")
    for sensors, truth, update in zip(sensed, truths, updates, strict=True):
        frames = {(t.parent_frame_id, t.child_frame_id): t for t in update.transforms}
        odom, real = frames["odom", "base_link"], frames["map", "base_link_truth"]
        assert (odom.translation.x, odom.translation.y) == tuple(sensors.odom[:2].tolist())
        assert (real.translation.x, real.translation.y) == (truth.x, truth.y)
        assert 2 * math.asin(real.rotation.z) == pytest.approx(truth.theta)
    starts = [update.transforms[0] for update in updates[:-1]]
    places = {(start.translation.x, start.translation.y) for start in starts}
    assert places == {(PLAN.start.x, PLAN.start.y)}


def composed(outer, inner):
    turn = 2 * math.atan2(outer.rotation.z, outer.rotation.w)
    cos, sin = math.cos(turn), math.sin(turn)
    x, y = inner.translation.x, inner.translation.y
    at = outer.translation
    theta = turn + 2 * math.atan2(inner.rotation.z, inner.rotation.w)
    return at.x + cos * x - sin * y, at.y + sin * x + cos * y, theta


def test_the_odometry_frame_lies_in_the_map_where_the_navigator_believes(recording):
    path, told = recording
    before, after = on_topic(path, "/tf")[-2:]
    real = next(message.state.position for message in told if isinstance(message, Belief))
    # The belief was of the tick before the last: the robot has moved on since.
    believed_then = composed(after.transforms[0], before.transforms[1])
    assert believed_then == pytest.approx((real.x, real.y, real.theta), abs=1e-6)


def test_doors_are_drawn_again_when_one_moves(recording):
    path, _ = recording
    before, after = on_topic(path, "/doors")
    shut = [len(update.entities[0].lines[0].points) // 2 for update in (before, after)]
    ajar = [len(update.entities[0].lines[1].points) // 2 for update in (before, after)]
    assert shut == [0, 1]
    assert ajar == [len(PLAN.doors), len(PLAN.doors) - 1]


def test_a_recording_cut_off_anywhere_has_a_readable_beginning(recording, tmp_path):
    path, _ = recording
    whole, data = read(path)[1], path.read_bytes()
    cut, lengths = tmp_path / "cut.mcap", []
    for size in np.linspace(len(data) // 3, len(data) - 200, 12, dtype=int):
        cut.write_bytes(data[:size])
        reader, entries = read(cut)
        assert not reader.is_finished or entries == whole
        assert entries == whole[: len(entries)]
        lengths.append(len(entries))
    assert lengths == sorted(lengths)
    assert len(set(lengths)) > 5


def test_a_recording_cut_off_in_its_head_is_a_clear_error(recording, tmp_path):
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(recording[0].read_bytes()[:300])
    with pytest.raises(RecordingFileError, match="is cut off before its first message"):
        read(cut)


def test_damage_in_the_middle_is_told(recording, tmp_path):
    with pytest.raises(RecordingFileError, match=r"is damaged after \d+ records"):
        read(damaged(recording[0], tmp_path))


def other_mcap(profile):
    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start(profile=profile, library="test")
    schema = writer.register_schema("Beginning", "jsonschema", b"{}")
    channel = writer.register_channel("/beginning", "json", schema)
    writer.add_message(channel, 0, b'{"seed": "x"}', 0)
    writer.finish()
    return stream.getvalue()


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "is no MCAP file"),
        (b"tick,sonar\n1,2.0\n" * 50, "is no MCAP file"),
        (other_mcap("tca"), "its profile is 'tca', not 'xavier'; 'tca replay' plays it"),
        (other_mcap("ros2"), "its profile is 'ros2', not 'xavier'"),
        (other_mcap("xavier"), "does not begin as a recording does: floor does not fit"),
    ],
)
def test_a_file_that_is_no_recording_is_a_clear_error(tmp_path, data, says):
    path = tmp_path / "other.mcap"
    path.write_bytes(data)
    with pytest.raises(RecordingFileError, match=says):
        read(path)


def test_a_file_that_is_not_there_is_a_clear_error(tmp_path):
    with pytest.raises(RecordingFileError, match=r"none.mcap cannot be opened \(No such file"):
        read(tmp_path / "none.mcap")


def test_a_missing_record_is_told(tmp_path, monkeypatch):
    path = tmp_path / "gap.mcap"
    with path.open("wb") as stream:
        tape = Tape(stream, beginning_of(fresh_state()))
        tape._channels.written += 1
        tape.note(Drive(tick=0, speed=0.0, turn_rate=0.0, busy=False), 1000.0)
        tape.finish(dropped=0)
    with pytest.raises(RecordingFileError, match="record 4 is not there"):
        read(path)


async def record(path, state):
    async with Recorder(path, beginning_of(state)) as recorder:
        for message, more in things(state):
            if isinstance(message, Sensors):
                await recorder.sense(message, more)
            else:
                recorder.note(message, more)
    return recorder


async def test_the_recorder_loses_no_tick_however_slow_the_disk(tmp_path, monkeypatch):
    monkeypatch.setattr(recorder_module, "MOST_SENSED", 2)
    monkeypatch.setattr(recorder_module, "MOST_WAITING", 0)
    path = tmp_path / "slow.mcap"
    recorder = await record(path, fresh_state())
    reader, entries = read(path)
    names = [entry.name for entry in entries]
    assert names.count("xavierSensors") == names.count("xavierDrive") == TICKS
    assert "xavierDoorMoved" not in names
    assert recorder.dropped == reader.dropped == 3
    assert reader.is_finished


async def test_the_file_is_complete_when_the_robot_ends_for_an_error(tmp_path):
    path, state = tmp_path / "broken.mcap", fresh_state()

    async def break_down():
        async with Recorder(path, beginning_of(state)) as recorder:
            await recorder.sense(state.sensors(), state.true_location())
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        await break_down()
    reader, entries = read(path)
    assert reader.is_finished
    assert [entry.name for entry in entries] == ["xavierSensors", "xavierTrueLocation.reply"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is full")
async def test_a_full_disk_stops_the_robot(monkeypatch):
    monkeypatch.setattr(recorder_module, "BATCH", 1)
    full = Path("/dev/full")
    with pytest.raises(RecordingFileError, match=r"full cannot be written any more \(No space"):
        await record(full, fresh_state())


async def test_a_file_that_cannot_be_made_is_a_clear_error(tmp_path):
    with pytest.raises(RecordingFileError, match=r"cannot be made \(No such file"):
        await record(tmp_path / "no" / "folder.mcap", fresh_state())
