"""Payloads: JSON, or a frame of a JSON header and raw arrays (`tca_bus._frames`).

The Zenoh encoding names the message and its revision: ``application/json;xavierDrive@1`` or
``application/x-tca-frame;xavierSensors@1``.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from importlib import import_module
from types import ModuleType
from typing import Any, TypeVar

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

MessageT = TypeVar("MessageT", bound=Message)

ANYTHING: TypeAdapter[Any] = TypeAdapter(Any)
"""Takes any JSON value."""

FIELDS = TypeAdapter(dict[str, Any])
"""Takes any JSON object."""

MOST_DIGITS = 10
"""A revision has fewer."""


@dataclass(frozen=True, slots=True)
class Payload:
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


def encode_message(message: Message) -> Payload:
    """Encode a message: JSON, or a frame if its type has array fields."""
    tag = f"{message.wire_name}@{message.revision}"
    if array_fields(type(message)):
        return _frame(message, tag)
    return Payload(message.model_dump_json().encode(), f"{JSON_TYPE};{tag}")


def encode_answer(
    answer: Any, adapter: TypeAdapter[Any], message: type[Message], *, told: int | None = None
) -> Payload:
    """Encode the answer to a message, in the form for a sender of revision ``told``."""
    name = message.wire_name + REPLY_SUFFIX
    if isinstance(answer, BaseModel) and array_fields(type(answer)):
        return _frame(answer, f"{name}@{message.revision}")
    if told is None or told == message.revision:
        return Payload(adapter.dump_json(answer), f"{JSON_TYPE};{name}@{message.revision}")
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
    name = message_type.wire_name
    told = _told_revision(payload.encoding, name)
    adapter = message_adapter(message_type)
    try:
        return understand(
            message_type,
            told,
            validate=lambda: _validate(payload, adapter, name),
            plain=lambda: _fields(payload, name),
        )
    except ValidationError as error:
        raise InvalidMessageError(name, problems_of(error)) from error


def told_revision(payload: Payload) -> int | None:
    """The revision that the sender says a payload is of; None if it does not say."""
    _, _, tag = payload.encoding.partition(";")
    told = _told_revision(payload.encoding, tag.partition("@")[0])
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
    return adapter.validate_json(payload.data)


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
