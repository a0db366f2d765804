"""Revisions: an older sender is understood where the types say how, and told so where not."""

from __future__ import annotations

import contextlib
import json
from typing import ClassVar

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict

from tca_bus import Broadcast, Command, InvalidMessageError, Module, Query, TaskFailedError
from tca_bus._types import answer_adapter
from tca_bus._wire import (
    JSON_TYPE,
    Payload,
    decode_answer,
    decode_message,
    encode_answer,
    encode_message,
)
from tca_bus.arrays import Float32Array
from tca_bus.testing import bus, central, eventually


class Pose(BaseModel):
    model_config = ConfigDict(extra="forbid")

    x: float
    y: float
    heading: float


class OldPose(BaseModel):
    model_config = ConfigDict(extra="forbid")

    x: float
    y: float


class OldWhere(Query[OldPose]):
    wire_name = "where"

    robot: str = "xavier"


class Where(Query[Pose]):
    """The second revision names robots by number, and gives a heading."""

    wire_name = "where"
    revision = 2
    accepts: ClassVar = (1,)

    number: int

    @classmethod
    def upgrade(cls, revision, data):
        return {"number": {"xavier": 7}[data["robot"]]}

    @classmethod
    def downgrade_answer(cls, revision, answer):
        return {"x": answer["x"], "y": answer["y"]}


class StrictWhere(Query[Pose]):
    """The second revision, which accepts no other."""

    wire_name = "where"
    revision = 2

    number: int


class OldGo(Command[OldPose]):
    wire_name = "go"

    to: str


class Go(Command[Pose]):
    wire_name = "go"
    revision = 2
    accepts: ClassVar = (1,)

    room: str

    @classmethod
    def upgrade(cls, revision, data):
        return {"room": data["to"]}

    @classmethod
    def downgrade_answer(cls, revision, answer):
        return {"x": answer["x"], "y": answer["y"]}


class Part(BaseModel):
    model_config = ConfigDict(extra="forbid")

    a: int = 0


class Told(Broadcast):
    a: int
    part: Part = Part()
    parts: tuple[Part, ...] = ()


class Scan(Broadcast):
    ranges: Float32Array


class NewScan(Broadcast):
    wire_name = "scan"

    ranges: Float32Array
    angle: float = 0.5


def test_an_accepted_revision_is_upgraded():
    assert decode_message(encode_message(OldWhere()), Where) == Where(number=7)


def test_an_upgrade_that_fails_names_both_revisions():
    with pytest.raises(InvalidMessageError, match=r"1 could not be upgraded to 2.*KeyError: 'hal'"):
        decode_message(encode_message(OldWhere(robot="hal")), Where)


def test_a_revision_that_is_not_accepted_names_both_and_the_fields_in_the_way():
    with pytest.raises(InvalidMessageError) as caught:
        decode_message(encode_message(OldWhere()), StrictWhere)
    first, *fields = caught.value.problems
    assert first == "revision: expected 2, got 1"
    assert [field.partition(":")[0] for field in fields] == ["number", "robot"]


def test_a_newer_sender_is_told_what_is_understood():
    with pytest.raises(InvalidMessageError, match="revision: expected 1, got 2; number: extra"):
        decode_message(encode_message(Where(number=7)), OldWhere)
    with pytest.raises(InvalidMessageError, match="revision: expected 1 or 2, got 3"):
        decode_message(Payload(b'{"number": 7}', f"{JSON_TYPE};where@3"), Where)


def test_fields_that_a_newer_sender_added_are_left_out_wherever_they_are():
    data = {"a": 1, "new": 2, "part": {"a": 3, "new": 4}, "parts": [{"a": 5}, {"new": 6}]}
    payload = Payload(json.dumps(data).encode(), f"{JSON_TYPE};told@1")
    expected = Told(a=1, part=Part(a=3), parts=(Part(a=5), Part()))
    assert decode_message(payload, Told) == expected
    frame = encode_message(NewScan(ranges=[1.5]))
    assert decode_message(frame, Scan).ranges.tolist() == [1.5]


def test_without_a_revision_an_unknown_field_is_a_mistake():
    with pytest.raises(InvalidMessageError, match="new: extra inputs"):
        decode_message(Payload(b'{"a": 1, "new": 2}', f"{JSON_TYPE};told"), Told)


@settings(deadline=None)
@given(
    st.dictionaries(st.sampled_from(["a", "part", "parts", "new"]), st.integers() | st.none()),
    st.sampled_from(["", "@1", "@2", "@", "@x", "@-1", "@" + "9" * 5000, "@٣"]),
)
def test_whatever_arrives_is_a_message_or_invalid(data, revision):
    payload = Payload(json.dumps(data).encode(), f"{JSON_TYPE};told{revision}")
    with contextlib.suppress(InvalidMessageError):
        assert isinstance(decode_message(payload, Told), Told)


def test_an_answer_goes_back_in_the_form_of_the_older_sender():
    pose = Pose(x=1, y=2, heading=3)
    old = encode_answer(pose, answer_adapter(Where), Where, told=1)
    assert decode_answer(old, answer_adapter(OldWhere), "where", revision=1) == OldPose(x=1, y=2)
    new = encode_answer(pose, answer_adapter(Where), Where, told=2)
    assert decode_answer(new, answer_adapter(Where), "where", revision=2) == pose
    with pytest.raises(InvalidMessageError, match="revision: expected 1, got 2; heading: extra"):
        decode_answer(new, answer_adapter(OldWhere), "where", revision=1)


@pytest.mark.bus
async def test_old_senders_and_a_new_module_understand_each_other():
    async with bus() as options, central(options), Module("old", options=options) as old:
        module = Module("new", options=options)

        @module.handler(Where)
        async def where(message, context):
            return Pose(x=message.number, y=2, heading=3)

        @module.handler(Go)
        async def go(message, context):
            return Pose(x=1, y=len(message.room), heading=3)

        async with module:
            await old.wait_for("where", "go", "tca.submit", timeout=10.0)
            assert await old.query(OldWhere()) == OldPose(x=7, y=2)
            task = await old.execute(OldGo(to="lab"))
            assert await task.result(timeout=10.0) == OldPose(x=1, y=3)
            with pytest.raises(InvalidMessageError, match="1 could not be upgraded to 2"):
                await old.query(OldWhere(robot="hal"))


@pytest.mark.bus
async def test_a_task_of_a_revision_that_is_not_understood_fails_with_both():
    async with bus() as options, central(options), Module("new", options=options) as new:
        module = Module("old", options=options)

        @module.handler(OldGo)
        async def go(message, context):
            return OldPose(x=1, y=2)

        async with module:
            await new.wait_for("go", "tca.submit", timeout=10.0)
            with pytest.raises(TaskFailedError, match="revision: expected 1, got 2"):
                await (await new.execute(Go(room="lab"))).result(timeout=10.0)


@pytest.mark.bus
async def test_a_broadcast_with_new_fields_is_heard_by_an_old_module():
    async with (
        bus() as options,
        Module("old", options=options) as old,
        Module("new", options=options) as new,
        old.subscribe(Scan) as scans,
    ):
        heard: list[list[float]] = []

        async def hears():
            await new.broadcast(NewScan(ranges=[2.5]))
            while scans.waiting:
                heard.append((await scans.get()).ranges.tolist())
            return heard

        await eventually(hears)
        assert heard[0] == [2.5]
