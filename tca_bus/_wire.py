"""Payloads: JSON, or a frame of a JSON header and raw arrays (`tca_bus._frames`).

The Zenoh encoding names the message and its revision: ``application/json;xavierDrive@1`` or
``application/x-tca-frame;xavierSensors@1``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import cache, lru_cache
from importlib import import_module
from types import ModuleType
from typing import Any, NamedTuple, TypeVar

from pydantic import BaseModel, TypeAdapter, ValidationError

from tca_bus._errors import InvalidMessageError
from tca_bus._messages import Message
from tca_bus._problems import problems_of
from tca_bus._revisions import answer_for, understand
from tca_bus._types import array_fields, message_adapter

JSON_TYPE = "application/json"
FRAME_TYPE = "application/x-tca-frame"
REPLY_SUFFIX = ".reply"
"""Appended to a message's name in the encoding of its answer."""

MOST_TOGETHER = 256
"""Messages in one payload, when many are sent together."""

MessageT = TypeVar("MessageT", bound=Message)

ANYTHING: TypeAdapter[Any] = TypeAdapter(Any)
"""Takes any JSON value."""

_ANY_LIST = TypeAdapter(list[Any])

FIELDS = TypeAdapter(dict[str, Any])
"""Takes any JSON object."""

MOST_DIGITS = 10
"""A revision has fewer."""


class Payload(NamedTuple):
    """Bytes and what they are."""

    data: bytes
    encoding: str


def build(message_type: type[MessageT], **fields: Any) -> MessageT:
    """Make a message of fields that come from a caller.

    Raises:
        InvalidMessageError: They do not fit.
    """
    try:
        return message_type(**fields)
    except ValidationError as error:
        raise InvalidMessageError(message_type.wire_name, problems_of(error)) from error


@cache
def json_encoding(message_type: type[Message], suffix: str = "") -> str:
    """The Zenoh encoding of a message type, or of its answers, when they are JSON."""
    return f"{JSON_TYPE};{message_type.wire_name}{suffix}@{message_type.revision}"


def encode_message(message: Message) -> Payload:
    """Encode a message: JSON, or a frame if its type has array fields."""
    write, encoding = _writer(type(message))
    return Payload(write(message), encoding)


def _frame_encoding(kind: type[Message]) -> str:
    return f"{FRAME_TYPE};{kind.wire_name}@{kind.revision}"


@cache
def _writer(kind: type[Message]) -> tuple[Callable[[Message], bytes], str]:
    """What writes messages of a type, and their encoding."""
    if array_fields(kind):
        write, arrays = _frames().encode_frame, array_fields(kind)
        return lambda message: write(message, arrays), _frame_encoding(kind)
    return message_adapter(kind).serializer.to_json, json_encoding(kind)


@cache
def _reader(kind: type[Message]) -> tuple[Callable[[bytes], Message], str]:
    """What reads messages of a type, and the encoding that they have as a rule."""
    validator = message_adapter(kind).validator
    if array_fields(kind):
        take_apart, name = _frames().decode_frame, kind.wire_name
        return lambda data: validator.validate_python(take_apart(data, name)), _frame_encoding(kind)
    return validator.validate_json, json_encoding(kind)


def encode_answer(
    answer: Any, adapter: TypeAdapter[Any], message: type[Message], *, told: int | None = None
) -> Payload:
    """Encode the answer to a message, in the form for a sender of revision ``told``."""
    name = message.wire_name + REPLY_SUFFIX
    if isinstance(answer, BaseModel) and array_fields(type(answer)):
        return _frame(answer, f"{name}@{message.revision}")
    if told is None or told == message.revision:
        return Payload(adapter.serializer.to_json(answer), json_encoding(message, REPLY_SUFFIX))
    plain, revision = answer_for(message, told, adapter.dump_python(answer, mode="json"))
    return Payload(json.dumps(plain).encode(), f"{JSON_TYPE};{name}@{revision}")


def encode_json(name: str, data: Any) -> Payload:
    """Encode plain data under a wire name, without a revision."""
    return Payload(json.dumps(data).encode(), f"{JSON_TYPE};{name}")


def decode_message(payload: Payload, message_type: type[Message]) -> Message:
    """Validate a payload as a message; one of a revision that it accepts is upgraded.

    Raises:
        InvalidMessageError: It is none; the error names fields, values and what was expected.
    """
    read, encoding = _reader(message_type)
    if payload.encoding == encoding:
        try:
            return read(payload.data)
        except ValidationError:
            return _decode_message(payload, message_type)
    return _decode_message(payload, message_type)


def _decode_message(payload: Payload, message_type: type[Message]) -> Message:
    """Validate a payload of any revision, and say what does not fit."""
    adapter, name = message_adapter(message_type), message_type.wire_name
    told = _told_revision(payload.encoding, name)
    try:
        return understand(
            message_type,
            told,
            validate=lambda: _validate(payload, adapter, name),
            plain=lambda: _fields(payload, name),
        )
    except ValidationError as error:
        raise InvalidMessageError(name, problems_of(error)) from error


def encode_messages(messages: Sequence[MessageT]) -> list[Payload]:
    """Encode messages of one type as few payloads: JSON arrays of at most `MOST_TOGETHER`.

    Those with array fields are a payload each.
    """
    kind = type(messages[0])
    if array_fields(kind):
        return [encode_message(message) for message in messages]
    write = _list_adapter(kind).serializer.to_json
    parts = [messages[i : i + MOST_TOGETHER] for i in range(0, len(messages), MOST_TOGETHER)]
    return [Payload(write(list(part)), json_encoding(kind)) for part in parts]


def decode_messages(payload: Payload, message_type: type[Message]) -> Sequence[Message]:
    """Validate a payload as one message, or as an array of them.

    Raises:
        InvalidMessageError: It is neither, or one of them does not fit: then none is taken.
    """
    # A frame begins with any byte, since that counts the bytes of its header.
    if payload.encoding.startswith(FRAME_TYPE) or not payload.data.startswith(b"["):
        return (decode_message(payload, message_type),)
    name = message_type.wire_name
    told = _told_revision(payload.encoding, name)
    if told in {None, message_type.revision}:
        return _decode(payload, _list_adapter(message_type), name)  # type: ignore[no-any-return]
    items = _decode(payload, _ANY_LIST, name)
    parts = [Payload(json.dumps(item).encode(), payload.encoding) for item in items]
    return [decode_message(part, message_type) for part in parts]


@cache
def _list_adapter(message_type: type[Message]) -> TypeAdapter[list[Message]]:
    return TypeAdapter(list[message_type])  # type: ignore[valid-type]


def told_revision(payload: Payload) -> int | None:
    """The revision that the sender says a payload is of; None if it does not say."""
    return _number_in(payload.encoding)


@lru_cache(maxsize=1024)
def _number_in(encoding: str) -> int | None:
    _, _, tag = encoding.partition(";")
    told = _told_revision(encoding, tag.partition("@")[0])
    return told if isinstance(told, int) else None


def decode_answer(
    payload: Payload, adapter: TypeAdapter[Any], name: str, *, revision: int | None = None
) -> Any:
    """Validate a payload as the answer to the message ``name`` of ``revision``.

    Raises:
        InvalidMessageError: It is none; if it is of another revision the error names both.
    """
    try:
        return _decode(payload, adapter, name + REPLY_SUFFIX)
    except InvalidMessageError as error:
        told = told_revision(payload)
        if revision is None or told in {None, revision}:
            raise
        first = f"revision: expected {revision}, got {told}"
        raise InvalidMessageError(error.message, [first, *error.problems]) from error


def decode_plain(payload: Payload, name: str) -> Any:
    """Decode a payload to plain data: JSON values, arrays as lists.

    Raises:
        InvalidMessageError: It is neither JSON nor a frame.
    """
    if not payload.encoding.startswith(FRAME_TYPE):
        return _decode(payload, ANYTHING, name)
    return _frames().decode_frame_plain(payload.data, name)


def validate_plain(data: Any, adapter: TypeAdapter[Any], name: str) -> Any:
    """Validate plain data as it comes from JSON.

    Raises:
        InvalidMessageError: The data do not fit.
    """
    try:
        return adapter.validate_python(data)
    except ValidationError as error:
        raise InvalidMessageError(name, problems_of(error)) from error


def _told_revision(encoding: str, name: str) -> int | str | None:
    """The revision that the encoding names; tools may leave the tag or the revision out.

    Raises:
        InvalidMessageError: It names another message.
    """
    _, _, tag = encoding.partition(";")
    told, _, revision = tag.partition("@")
    if told and told != name:
        raise InvalidMessageError(name, [f"encoding: expected {name!r}, got {told[:100]!r}"])
    is_number = revision.isascii() and revision.isdigit() and len(revision) < MOST_DIGITS
    return int(revision) if is_number else (revision[:20] or None)


def _decode(payload: Payload, adapter: TypeAdapter[Any], name: str) -> Any:
    try:
        return _validate(payload, adapter, name)
    except ValidationError as error:
        raise InvalidMessageError(name, problems_of(error)) from error


def _validate(payload: Payload, adapter: TypeAdapter[Any], name: str) -> Any:
    if payload.encoding.startswith(FRAME_TYPE):
        return adapter.validate_python(_frames().decode_frame(payload.data, name))
    return adapter.validator.validate_json(payload.data)


def _fields(payload: Payload, name: str) -> dict[str, Any]:
    """The fields of a payload, arrays as such."""
    if payload.encoding.startswith(FRAME_TYPE):
        return _frames().decode_frame(payload.data, name)  # type: ignore[no-any-return]
    return FIELDS.validate_json(payload.data)


def _frame(model: BaseModel, tag: str) -> Payload:
    return Payload(_frames().encode_frame(model, array_fields(type(model))), f"{FRAME_TYPE};{tag}")


def _frames() -> ModuleType:
    """The coder of arrays, and with it numpy, which most programs on the bus never need."""
    return import_module("tca_bus._frames")
