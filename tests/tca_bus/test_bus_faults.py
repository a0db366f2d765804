"""Errors cross the bus as the class that they were."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from tca_bus import (
    BusGoneError,
    BusyError,
    Failure,
    HandlerFailedError,
    InvalidMessageError,
    KilledError,
    NoHandlerError,
    PeerLostError,
    RefusedError,
    TaskError,
    TaskFailedError,
    TimedOutError,
)
from tca_bus._faults import decode_error, encode_error, failure_of
from tca_bus._wire import Payload

SAME = [
    BusyError("the query", "too many waiting"),
    NoHandlerError("navigateToG", ["navigateToG2"]),
    InvalidMessageError("navigateToG", ["x: missing"]),
    RefusedError("kill", "not yours"),
    TimedOutError("query 'where'", 3.0),
    KilledError("rogue-1", "no longer wanted"),
    PeerLostError("navigate", "where"),
]


class Blocked(BaseModel):
    room: str


def across(error):
    return decode_error(encode_error(error, message="q", module="m"), message="q")


@pytest.mark.parametrize("error", SAME, ids=lambda error: type(error).__name__)
def test_errors_with_a_meaning_of_their_own_keep_class_and_facts(error):
    back = across(error)
    assert type(back) is type(error)
    assert vars(back) == vars(error)
    assert str(back) == str(error)


def test_a_handlers_failure_keeps_name_text_and_data():
    back = across(TaskError("door_blocked", "the door is closed", data=Blocked(room="r-5303")))
    assert isinstance(back, HandlerFailedError)
    assert back.failure.name == "door_blocked"
    assert back.failure.text == "the door is closed"
    assert back.failure.data == {"room": "r-5303"}
    assert back.failure.module == "m"


def test_any_other_exception_is_a_handler_error_with_its_class():
    back = across(KeyError("x"))
    assert isinstance(back, HandlerFailedError)
    assert back.failure.name == "handler_error"
    assert back.failure.text == "KeyError: 'x'"


@pytest.mark.parametrize(
    "error",
    [
        TaskError("", "no name"),
        TaskError("n" * 300, "too long a name"),
        TaskError("odd", "no JSON", data={"distance": np.float32(1.5)}),
        TaskError("odd", "no object", data=["r-5303"]),
        OSError("a file named \udcff"),
    ],
    ids=["no name", "long name", "no JSON", "no object", "no UTF-8"],
)
def test_what_cannot_be_sent_is_a_handler_error_that_says_so(error):
    back = across(error)
    assert isinstance(back, HandlerFailedError)
    assert back.failure.name == "handler_error"
    assert type(error).__name__ in back.failure.text
    assert "cannot be sent as it is" in back.failure.text


def test_a_lost_bus_inside_a_handler_is_not_a_lost_bus_for_the_caller():
    back = across(BusGoneError("tcp/127.0.0.1:1"))
    assert isinstance(back, HandlerFailedError)
    assert back.failure.name == "bus_gone"


def test_the_failure_of_a_sub_task_becomes_the_cause():
    inner = Failure(name="bump", text="contact", node="child")
    error = TaskFailedError("child", inner)
    failure = failure_of(error, message="deliver", module="rogue", node="parent")
    assert failure.name == "bump"
    assert failure.node == "parent"
    assert failure.chain() == [failure, inner]


@given(st.binary(max_size=200))
def test_an_error_reply_that_is_none_is_an_invalid_message(data):
    assert isinstance(decode_error(Payload(data, ""), message="q"), InvalidMessageError)


@pytest.mark.parametrize(
    "facts",
    [
        {},
        {"error": "odd"},
        {"error": "refused"},
        {"error": 3},
        {"error": "no_handler", "message": "q", "known": [5]},
    ],
)
def test_an_error_reply_without_its_facts_is_an_invalid_message(facts):
    payload = Payload(json.dumps(facts).encode(), "")
    assert isinstance(decode_error(payload, message="q"), InvalidMessageError)
