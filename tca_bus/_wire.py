"""Payloads: JSON, or a frame of a JSON header and raw arrays.

A frame is: header length (u32, little endian), header (JSON), arrays one after the other. The
header is ``{"fields": {...}, "arrays": [{"name": .., "dtype": "<f4", "length": 24}, ..]}``;
arrays are little endian, one-dimensional. The Zenoh encoding names the message and its revision:
``application/json;xavierDrive@1`` or ``application/x-tca-frame;xavierSensors@1``.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from tca_bus._errors import InvalidMessageError
from tca_bus._messages import Message
from tca_bus._types import array_fields, message_adapter

JSON_TYPE = "application/json"
FRAME_TYPE = "application/x-tca-frame"
REPLY_SUFFIX = ".reply"
"""Appended to a message's name in the encoding of its answer."""

MOST_PROBLEMS = 8
"""How many problems of one payload an error names."""

MessageT = TypeVar("MessageT", bound=Message)

ANYTHING: TypeAdapter[Any] = TypeAdapter(Any)
"""Takes any JSON value."""

_HEADER_LENGTH = struct.Struct("<I")


@dataclass(frozen=True, slots=True)
class Payload:
    """Bytes and what they are."""

    data: bytes
    encoding: str


class _ArrayHeader(BaseModel):
    model_config = ConfigDict(extra="forbid")

    name: str
    dtype: Annotated[str, Field(pattern=r"^[<|](f[248]|[iu][1248]|b1)$")]
    length: Annotated[int, Field(ge=0, le=1 << 28)]


class _FrameHeader(BaseModel):
    model_config = ConfigDict(extra="forbid")

    fields: dict[str, Any]
    arrays: list[_ArrayHeader]


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
        return Payload(_encode_frame(message), f"{FRAME_TYPE};{tag}")
    return Payload(message.model_dump_json().encode(), f"{JSON_TYPE};{tag}")


def encode_answer(answer: Any, adapter: TypeAdapter[Any], message: type[Message]) -> Payload:
    """Encode the answer to a message."""
    tag = f"{message.wire_name}{REPLY_SUFFIX}@{message.revision}"
    if isinstance(answer, BaseModel) and array_fields(type(answer)):
        return Payload(_encode_frame(answer), f"{FRAME_TYPE};{tag}")
    return Payload(adapter.dump_json(answer), f"{JSON_TYPE};{tag}")


def encode_json(name: str, data: Any) -> Payload:
    """Encode plain data under a wire name, without a revision."""
    return Payload(json.dumps(data).encode(), f"{JSON_TYPE};{name}")


def decode_message(payload: Payload, message_type: type[Message]) -> Message:
    """Validate a payload as a message.

    Raises:
        InvalidMessageError: It is none; the error names fields, values and what was expected.
    """
    name = message_type.wire_name
    _check_tag(payload.encoding, name, message_type.revision)
    return _decode(payload, message_adapter(message_type), name)  # type: ignore[no-any-return]


def decode_answer(payload: Payload, adapter: TypeAdapter[Any], name: str) -> Any:
    """Validate a payload as the answer to the message ``name``.

    Raises:
        InvalidMessageError: It is none.
    """
    return _decode(payload, adapter, name + REPLY_SUFFIX)


def decode_plain(payload: Payload, name: str) -> Any:
    """Decode a payload to plain data: JSON values, arrays as lists.

    Raises:
        InvalidMessageError: It is neither JSON nor a frame.
    """
    if not payload.encoding.startswith(FRAME_TYPE):
        return _decode(payload, ANYTHING, name)
    fields = _decode_frame(payload.data, name)
    return {
        key: value.tolist() if isinstance(value, np.ndarray) else value
        for key, value in fields.items()
    }


def validate_plain(data: Any, adapter: TypeAdapter[Any], name: str) -> Any:
    """Validate plain data as it comes from JSON.

    Raises:
        InvalidMessageError: The data do not fit.
    """
    try:
        return adapter.validate_python(data)
    except ValidationError as error:
        raise InvalidMessageError(name, problems_of(error)) from error


def problems_of(error: ValidationError) -> list[str]:
    """One sentence for each problem: the field, what was expected, what was there."""
    found = error.errors(include_url=False, include_context=False)
    sentences = [_sentence(problem) for problem in found[:MOST_PROBLEMS]]
    if len(found) > MOST_PROBLEMS:
        sentences.append(f"and {len(found) - MOST_PROBLEMS} more")
    return sentences


def _sentence(problem: Any) -> str:
    where = ".".join(str(part) for part in problem["loc"]) or "payload"
    text = problem["msg"][:1].lower() + problem["msg"][1:]
    shown = repr(problem["input"])
    if len(shown) > 80:
        shown = shown[:77] + "..."
    return f"{where}: {text}" if problem["type"] == "missing" else f"{where}: {text}, got {shown}"


def _check_tag(encoding: str, name: str, revision: int) -> None:
    """Reject a payload that says it is something else; tools may leave the tag out."""
    _, _, tag = encoding.partition(";")
    told, _, told_revision = tag.partition("@")
    if told and told != name:
        raise InvalidMessageError(name, [f"encoding: expected {name!r}, got {told!r}"])
    if told_revision and told_revision != str(revision):
        problem = f"revision: expected {revision}, got {told_revision[:20]!r}"
        raise InvalidMessageError(name, [problem])


def _decode(payload: Payload, adapter: TypeAdapter[Any], name: str) -> Any:
    try:
        if payload.encoding.startswith(FRAME_TYPE):
            return adapter.validate_python(_decode_frame(payload.data, name))
        return adapter.validate_json(payload.data)
    except ValidationError as error:
        raise InvalidMessageError(name, problems_of(error)) from error


def _encode_frame(model: BaseModel) -> bytes:
    kinds = array_fields(type(model))
    arrays = {name: np.ascontiguousarray(getattr(model, name), kinds[name]) for name in kinds}
    header = {
        "fields": model.model_dump(mode="json", exclude=set(kinds)),
        "arrays": [
            {"name": name, "dtype": array.dtype.str, "length": len(array)}
            for name, array in arrays.items()
        ],
    }
    text = json.dumps(header, separators=(",", ":")).encode()
    return b"".join([_HEADER_LENGTH.pack(len(text)), text, *(a.tobytes() for a in arrays.values())])


def _decode_frame(data: bytes, name: str) -> dict[str, Any]:
    header, offset = _read_header(data, name)
    fields = dict(header.fields)
    for entry in header.arrays:
        dtype = np.dtype(entry.dtype)
        end = offset + entry.length * dtype.itemsize
        if end > len(data):
            problem = f"{entry.name}: expected {end} bytes of frame, got {len(data)}"
            raise InvalidMessageError(name, [problem])
        fields[entry.name] = np.frombuffer(data, dtype, entry.length, offset)
        offset = end
    if offset != len(data):
        problem = f"frame: expected {offset} bytes, got {len(data)}"
        raise InvalidMessageError(name, [problem])
    return fields


def _read_header(data: bytes, name: str) -> tuple[_FrameHeader, int]:
    size = _HEADER_LENGTH.size
    if len(data) < size:
        raise InvalidMessageError(name, [f"frame: expected at least {size} bytes, got {len(data)}"])
    end = size + _HEADER_LENGTH.unpack_from(data)[0]
    if end > len(data):
        raise InvalidMessageError(name, [f"frame: header of {end} bytes in {len(data)}"])
    try:
        return _FrameHeader.model_validate_json(data[size:end]), end
    except ValidationError as error:
        raise InvalidMessageError(name, problems_of(error)) from error
