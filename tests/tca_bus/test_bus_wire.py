"""Payloads: what goes in comes out, and what does not fit says why."""

from __future__ import annotations

import contextlib
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydantic import Field, TypeAdapter

from tca_bus import Broadcast, InvalidMessageError, Query
from tca_bus._types import answer_adapter, answer_type
from tca_bus._wire import (
    FRAME_TYPE,
    JSON_TYPE,
    MOST_TOGETHER,
    Payload,
    decode_answer,
    decode_message,
    decode_messages,
    decode_plain,
    encode_answer,
    encode_json,
    encode_message,
    encode_messages,
)
from tca_bus.arrays import Float32Array


class Scan(Broadcast):
    tick: int = Field(ge=0)
    ranges: Float32Array
    odom: Float32Array


class Mark(Broadcast):
    name: str
    ranges: Float32Array


class Place(Broadcast):
    wire_name = "place"
    revision = 3

    x: float
    name: str


class Ask(Query[list[int]]):
    about: str


floats = st.floats(width=32, allow_nan=False)


@given(
    arrays(np.float32, st.integers(0, 300), elements=floats),
    arrays(np.float32, 3, elements=floats),
    st.integers(0, 1 << 40),
)
def test_arrays_travel_as_raw_floats_and_come_back_bit_for_bit(ranges, odom, tick):
    payload = encode_message(Scan(tick=tick, ranges=ranges, odom=odom))
    assert payload.encoding == f"{FRAME_TYPE};scan@1"
    assert payload.data.endswith(ranges.astype("<f4").tobytes() + odom.astype("<f4").tobytes())
    back = decode_message(payload, Scan)
    assert isinstance(back, Scan)
    assert back.tick == tick
    assert back.ranges.tobytes() == ranges.tobytes()
    assert back.odom.tobytes() == odom.tobytes()


@given(st.floats(allow_nan=False), st.text())
def test_json_messages_come_back_equal(x, name):
    payload = encode_message(Place(x=x, name=name))
    assert payload.encoding == f"{JSON_TYPE};place@3"
    assert decode_message(payload, Place) == Place(x=x, name=name)


@given(st.lists(st.tuples(st.floats(allow_nan=False), st.text()), min_size=1, max_size=600))
def test_messages_that_travel_together_come_back_in_order(values):
    places = [Place(x=x, name=name) for x, name in values]
    payloads = encode_messages(places)
    assert len(payloads) == -(-len(places) // MOST_TOGETHER)
    assert [one for payload in payloads for one in decode_messages(payload, Place)] == places


def test_messages_with_arrays_travel_alone_and_one_message_may():
    scans = [Scan(tick=tick, ranges=[], odom=[]) for tick in range(3)]
    assert [p.encoding for p in encode_messages(scans)] == [f"{FRAME_TYPE};scan@1"] * 3
    place = Place(x=1, name="lab")
    assert list(decode_messages(encode_message(place), Place)) == [place]


def test_a_frame_is_one_message_whatever_its_header_is_long():
    first_bytes = set()
    for length in range(256):
        mark = Mark(name="x" * length, ranges=[1.0])
        payload = encode_message(mark)
        first_bytes.add(payload.data[0])
        (back,) = decode_messages(payload, Mark)
        assert isinstance(back, Mark)
        assert (back.name, back.ranges.tolist()) == (mark.name, [1.0])
    assert len(first_bytes) == 256


def test_of_messages_that_travel_together_one_that_does_not_fit_is_named():
    payload = Payload(b'[{"x": 1, "name": "lab"}, {"x": "far", "name": "lab"}]', JSON_TYPE)
    with pytest.raises(InvalidMessageError, match=r"1\.x: input should be a valid number"):
        decode_messages(payload, Place)
    with pytest.raises(InvalidMessageError, match="revision: expected 3, got 2"):
        decode_messages(Payload(b'[{"x": 1}]', f"{JSON_TYPE};place@2"), Place)


def test_infinite_ranges_survive_in_a_frame_and_in_json():
    scan = Scan(tick=1, ranges=[math.inf, 1.0], odom=[0.0, 0.0, 0.0])
    framed = decode_message(encode_message(scan), Scan)
    assert isinstance(framed, Scan)
    assert framed.ranges.tolist() == [math.inf, 1.0]
    listed = decode_message(encode_json("scan", json.loads(scan.model_dump_json())), Scan)
    assert isinstance(listed, Scan)
    assert listed.ranges.tolist() == [math.inf, 1.0]


def test_plain_data_of_a_frame_has_lists():
    payload = encode_message(Scan(tick=1, ranges=[1.0, 2.5], odom=[]))
    assert decode_plain(payload, "scan") == {"tick": 1, "ranges": [1.0, 2.5], "odom": []}


@given(st.binary(max_size=400), st.sampled_from([JSON_TYPE, FRAME_TYPE, "", "zenoh/bytes"]))
def test_random_bytes_are_an_invalid_message_and_nothing_else(data, encoding):
    with pytest.raises(InvalidMessageError):
        decode_message(Payload(data, encoding), Scan)


@given(st.data())
def test_a_damaged_frame_is_invalid_or_still_a_scan(data):
    whole = encode_message(Scan(tick=7, ranges=[1.0] * 24, odom=[0.0] * 3))
    bad = bytearray(whole.data)
    for _ in range(data.draw(st.integers(1, 4))):
        bad[data.draw(st.integers(0, len(bad) - 1))] = data.draw(st.integers(0, 255))
    cut = bytes(bad[: data.draw(st.integers(0, len(bad)))])
    with contextlib.suppress(InvalidMessageError):
        assert isinstance(decode_message(Payload(cut, whole.encoding), Scan), Scan)


@pytest.mark.parametrize("kind", [*"fiub"])
@pytest.mark.parametrize("size", [*"1248"])
@pytest.mark.parametrize("order", [*"<|"])
def test_a_frame_with_any_number_type_is_read_or_invalid(kind, size, order):
    header = {"fields": {}, "arrays": [{"name": "ranges", "dtype": order + kind + size}]}
    header["arrays"][0]["length"] = 0
    text = json.dumps(header).encode()
    frame = Payload(len(text).to_bytes(4, "little") + text, FRAME_TYPE)
    with contextlib.suppress(InvalidMessageError):
        assert decode_plain(frame, "scan") == {"ranges": []}


def framed(header: str) -> Payload:
    return Payload(len(header).to_bytes(4, "little") + header.encode(), FRAME_TYPE)


@pytest.mark.parametrize(
    "header",
    [
        '{"fields":{"a":{"b":1,"arrays":[]}},"arrays":[]}',
        '{"arrays":[],"fields":{"a":{"b":1,"arrays":[]}}}',
        '{ "fields" : {"a":{"b":1,"arrays":[]}} , "arrays" : [] } ',
        '{"fields":{"a":{"b":1,"arrays":[]}}, "arrays":[]}',
    ],
)
def test_a_frame_s_header_may_be_written_in_any_order_and_with_space(header):
    assert decode_plain(framed(header), "scan") == {"a": {"b": 1, "arrays": []}}


@pytest.mark.parametrize(
    "header",
    [
        '{"fields":{},"more":1,"arrays":[]}',
        '{"fields":{"a":1,"arrays":[]}}',
        '{"fields":{"a":1,"arrays":[]}',
        '{"fields":{},"arrays":[]',
        '{"fields":[],"arrays":[]}',
        '{"fields":{},"arrays":[{"name":"a","dtype":"<f4","length":-1}]}',
        '{"fields":{},"arrays":[{"name":"a","dtype":"O","length":0}]}',
    ],
)
def test_a_header_that_says_more_or_less_is_no_frame_s(header):
    with pytest.raises(InvalidMessageError):
        decode_plain(framed(header), "scan")


def test_the_error_names_field_value_and_what_was_expected():
    payload = encode_json("place", {"x": "far", "nam": "lab"})
    with pytest.raises(InvalidMessageError) as caught:
        decode_message(payload, Place)
    text = str(caught.value)
    assert "'place'" in text
    assert "x: input should be a valid number" in text
    assert "'far'" in text
    assert "name: field required" in text
    assert "nam: extra inputs are not permitted" in text


def test_another_name_or_revision_is_told():
    whole = encode_message(Place(x=1, name="lab"))
    with pytest.raises(InvalidMessageError, match="revision: expected 3, got 2"):
        decode_message(Payload(whole.data, f"{JSON_TYPE};place@2"), Place)
    with pytest.raises(InvalidMessageError, match="expected 'place', got 'scan'"):
        decode_message(Payload(whole.data, f"{JSON_TYPE};scan@3"), Place)
    assert decode_message(Payload(whole.data, "zenoh/bytes"), Place) == Place(x=1, name="lab")


def test_answers_are_typed_by_their_query():
    assert answer_type(Ask) == list[int]
    adapter = answer_adapter(Ask)
    payload = encode_answer([1, 2], adapter, Ask)
    assert payload == Payload(b"[1,2]", f"{JSON_TYPE};ask.reply@1")
    assert decode_answer(payload, adapter, "ask") == [1, 2]
    with pytest.raises(InvalidMessageError, match=r"ask\.reply"):
        decode_answer(Payload(b'["x"]', JSON_TYPE), adapter, "ask")


def test_an_answer_with_arrays_is_a_frame():
    adapter = TypeAdapter(Scan)
    payload = encode_answer(Scan(tick=1, ranges=[1.5], odom=[]), adapter, Ask)
    assert payload.encoding == f"{FRAME_TYPE};ask.reply@1"
    assert decode_answer(payload, adapter, "ask").ranges.tolist() == [1.5]


@pytest.mark.parametrize("number", [1e308, -1e308, 10**400])
def test_a_number_that_is_too_big_for_its_array_is_invalid(number):
    data = json.dumps({"tick": 1, "ranges": [number], "odom": []}).encode()
    with pytest.raises(
        InvalidMessageError, match="ranges: value error, expected a list of numbers"
    ):
        decode_message(Payload(data, JSON_TYPE), Scan)
