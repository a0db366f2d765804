"""Random and mutated bytes on every family of keys: refused with a reason, and nothing crashes."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import random

import pytest
import zenoh
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter

from tca_bus import (
    Broadcast,
    Command,
    Inform,
    InvalidMessageError,
    Module,
    Query,
    TcaError,
    Variable,
)
from tca_bus._envelope import Envelope, read_envelope
from tca_bus._faults import decode_error
from tca_bus._frames import decode_frame, decode_frame_plain
from tca_bus._joining import client_config
from tca_bus._keys import Keys, parse_presence, parse_query, parse_sender, parse_task
from tca_bus._protocol import (
    CancelTask,
    Describe,
    FindTask,
    HandleTask,
    KillTask,
    ListTasks,
    Outcome,
    ReadLog,
    ReportOutcome,
    SubmitTask,
)
from tca_bus._tasks import STATUS_ENCODING, decode_status
from tca_bus._turns import AwaitTurn, WithdrawRequest
from tca_bus._types import message_adapter
from tca_bus._variables import GetVariable, ListVariables, SetVariable
from tca_bus._wire import FRAME_TYPE, JSON_TYPE, Payload, decode_answer, decode_message
from tca_bus.arrays import Float32Array
from tca_bus.testing import bus, central, eventually

SEED = 1998
ROUNDS = 6


class Ask(Query[int]):
    number: int


class Tell(Inform):
    number: int


class Shout(Broadcast):
    ranges: Float32Array
    number: int = 0


class Quick(Command[int]):
    number: int


ENCODINGS = st.sampled_from(
    [
        "",
        JSON_TYPE,
        f"{JSON_TYPE};shout@1",
        f"{JSON_TYPE};shout@2",
        f"{JSON_TYPE};other@1",
        FRAME_TYPE,
        f"{FRAME_TYPE};shout@1",
        f"{FRAME_TYPE};;@@",
    ]
)
FRAME = b'{"fields": {"number": 1}, "arrays": [{"name": "ranges", "dtype": "<f4", "length": 1}]}'
WHOLE = len(FRAME).to_bytes(4, "little") + FRAME + b"\0\0\0\0"


@st.composite
def mutated(draw, whole=WHOLE):
    """A frame with some bytes changed, cut off or put in."""
    data = bytearray(whole)
    for _ in range(draw(st.integers(0, 4))):
        place = draw(st.integers(0, len(data)))
        data[place : place + draw(st.integers(0, 3))] = draw(st.binary(max_size=3))
    return bytes(data)


@settings(deadline=None)
@given(mutated() | st.binary(max_size=200), ENCODINGS)
def test_a_payload_is_a_message_or_invalid(data, encoding):
    payload = Payload(data, encoding)
    with contextlib.suppress(InvalidMessageError):
        assert isinstance(decode_message(payload, Shout), Shout)
    with contextlib.suppress(InvalidMessageError):
        decode_answer(payload, TypeAdapter(list[int]), "ask", revision=1)
    with contextlib.suppress(InvalidMessageError):
        decode_status(payload)
    assert isinstance(decode_error(payload, message="ask"), TcaError)


@settings(deadline=None)
@given(mutated() | st.binary(max_size=200))
def test_a_frame_or_an_attachment_is_one_or_invalid(data):
    for read, kind in (
        (lambda: decode_frame(data, "x"), dict),
        (lambda: decode_frame_plain(data, "x"), dict),
        (lambda: read_envelope(data), Envelope),
    ):
        with contextlib.suppress(InvalidMessageError):
            assert isinstance(read(), kind)


@settings(deadline=None)
@given(st.lists(st.sampled_from(["", "a", "*", "**", "1", "-", "+x", ",", "held", "x,y"])))
def test_a_key_is_read_or_is_a_value_error(chunks):
    key = "/".join(chunks)
    assert parse_sender(key) == (chunks[-1] if chunks else "")
    assert set(parse_task(key)) <= {*chunks, "*"}
    for parse in (parse_query, parse_presence):
        with contextlib.suppress(ValueError):
            assert parse(key) is not None


VALID = [
    (Describe, {}),
    (AwaitTurn, {"message": "ask", "request": "r"}),
    (WithdrawRequest, {"message": "ask", "request": "r"}),
    (HandleTask, {"id": "t", "attempt": 1, "name": "quick", "task_class": "command",
                  "data": {"number": 1}, "sender": "x"}),
    (CancelTask, {"id": "t", "attempt": 1, "reason": "because"}),
    (SubmitTask, {"id": "t", "name": "quick", "task_class": "command", "data": {"number": 1},
                  "sender": "x"}),
    (KillTask, {"id": "t"}),
    (FindTask, {"id": "t"}),
    (ListTasks, {"id": "t"}),
    (ReadLog, {"most": 5}),
    (ReportOutcome, {"id": "t", "attempt": 1, "outcome": Outcome.SUCCESS}),
    (SetVariable, {"name": "a", "value": 1, "change": "c"}),
    (GetVariable, {"name": "a"}),
    (ListVariables, {}),
    (Ask, {"number": 1}),
]  # fmt: skip


def test_what_is_mutated_is_valid_before():
    for kind, fields in VALID:
        assert isinstance(message_adapter(kind).validate_python(fields), kind)


class Chaos:
    """Payloads, encodings, attachments and names, all from one seed."""

    def __init__(self, seed):
        self._random = random.Random(seed)

    def payload(self, valid):
        pick = self._random.random()
        if pick < 0.2:
            return self._random.randbytes(self._random.randrange(200))
        if pick < 0.5:
            return json.dumps(self._other_fields(valid)).encode()
        data = bytearray(json.dumps(valid, default=str).encode())
        for _ in range(self._random.randrange(4)):
            data[self._random.randrange(len(data))] = self._random.randrange(256)
        return bytes(data)

    def _other_fields(self, valid):
        odd = [None, -1, 2**70, 1e308, "", "x" * 5000, [], {"a": {}}, "../*", True]
        fields = dict(valid)
        for name in self._random.sample([*fields, "odd"], k=min(2, len(fields) + 1)):
            fields[name] = self._random.choice(odd)
        return {name: str(v) if isinstance(v, Outcome) else v for name, v in fields.items()}

    def encoding(self, name):
        tags = ["", name, f"{name}@1", f"{name}@7", f"{name}@x", "other@1"]
        kind = self._random.choice([JSON_TYPE, FRAME_TYPE, "text/plain"])
        return f"{kind};{self._random.choice(tags)}"

    def attachment(self):
        return self._random.choice(
            [
                None,
                b"",
                self._random.randbytes(50),
                json.dumps({"id": f"r{self._random.randrange(5)}", "sender": "forged"}).encode(),
                b'{"id": "x", "traceparent": "00-0-0-0"}',
                b'{"id": ""}',
            ]
        )

    def caller(self):
        return self._random.choice(["x", "central", "me", "server", "nobody"])


def fire(session, keys, incarnations, chaos):
    """Put and ask everything once; gives how many replies each question had. On a thread."""
    families = [
        *(keys.one_way(kind, name, chaos.caller())
          for kind in ("inform", "broadcast", "heartbeat")
          for name in ("tell", "shout", "tca.heartbeat", "tca.simTime", "tca.awaitTime")),
        keys.task("me", "t"),
        keys.task("server", "gone"),
        keys.variable("a"),
    ]  # fmt: skip
    for key in families:
        encoding = zenoh.Encoding(chaos.encoding(key.split("/")[2]))
        payload = chaos.payload({"number": 1, "ranges": [1.0]})
        session.put(key, payload, encoding=encoding, attachment=chaos.attachment())
    counts = []
    for kind, fields in VALID:
        for module, incarnation in incarnations.items():
            key = f"{keys.realm}/query/{module}/{incarnation}/{kind.wire_name}/{chaos.caller()}"
            replies = session.get(
                key,
                payload=chaos.payload(fields),
                encoding=zenoh.Encoding(chaos.encoding(kind.wire_name)),
                attachment=chaos.attachment(),
                timeout=5.0,
            )
            counts.append((key, sum(1 for _ in replies)))
    return counts


def served(options):
    module = Module("server", options=options)

    async def number(message, context):
        return message.number

    for kind in (Ask, Tell, Shout, Quick):
        module.serve(kind, number)
    return module


@pytest.mark.bus
@pytest.mark.timeout(120)
async def test_mutated_messages_on_every_key_harm_nothing(caplog):
    caplog.set_level(logging.WARNING, logger="tca_bus")
    chaos = Chaos(SEED)
    battery = Variable("battery", float)
    async with (
        bus() as options,
        central(options),
        served(options) as server,
        Module("me", options=options) as me,
        me.watch(battery) as changes,
    ):
        await me.wait_for(Ask, Quick, SubmitTask, timeout=10.0)
        incarnations = {m.name: m.incarnation for m in me.modules() if m.name != "me"}
        stranger = await asyncio.to_thread(zenoh.open, client_config(options))
        try:
            for number in range(ROUNDS):
                counts = await asyncio.to_thread(
                    fire, stranger, Keys(options.realm), incarnations, chaos
                )
                assert [key for key, count in counts if count != 1] == [], f"seed {SEED}"
                assert await me.query(Ask(number=number)) == number
                await me.set(battery, float(number))
                task = await me.execute(Quick(number=number))
                assert await task.result(timeout=20.0) == number
        finally:
            await asyncio.to_thread(stranger.close)
        while (await anext(changes)).value != ROUNDS - 1:
            pass
        card = await me.query(Describe(), to="server")
        assert card.invalid > ROUNDS
        assert card.dropped == {}
        await eventually(lambda: server.is_connected)
    crashes = [record for record in caplog.records if record.exc_info]
    assert [record.getMessage() for record in crashes] == []
    told = [record.getMessage() for record in caplog.records if "no valid 'ask'" in record.message]
    assert len(told) <= 6, "one cause was told again and again"


@pytest.mark.bus
async def test_an_outcome_of_a_node_that_is_gone_changes_nothing():
    async with (
        bus() as options,
        central(options),
        served(options),
        Module("me", options=options) as me,
    ):
        await me.wait_for(Quick, SubmitTask, timeout=10.0)
        for id in ("never", "other"):
            report = ReportOutcome(id=id, attempt=3, outcome=Outcome.SUCCESS, result=1)
            assert (await me.query(report, to="central")).id == id
        assert await me.query(ListTasks(), to="central") == []
        task = await me.execute(Quick(number=1))
        assert await task.result(timeout=10.0) == 1
        late = ReportOutcome(id=task.id, attempt=1, outcome=Outcome.KILLED)
        await me.query(late, to="central")
        assert (await me.query(FindTask(id=task.id), to="central")).state == "achieved"


@pytest.mark.bus
async def test_a_state_with_a_wrong_shape_moves_no_handle():
    async with (
        bus() as options,
        central(options),
        served(options),
        Module("me", options=options) as me,
    ):
        await me.wait_for(Quick, SubmitTask, timeout=10.0)
        task = await me.execute(Quick(number=1))
        keys = Keys(options.realm)
        payload = Payload(b'{"id": "x"}', STATUS_ENCODING)
        me._parts.topics.send(keys.task("me", task.id), payload)
        assert await task.result(timeout=10.0) == 1
