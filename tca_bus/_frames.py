"""Frames: a JSON header and raw arrays, for messages with array fields.

A frame is: header length (u32, little endian), header (JSON), arrays one after the other. The
header is ``{"fields": {...}, "arrays": [{"name": .., "dtype": "<f4", "length": 24}, ..]}``;
arrays are little endian, one-dimensional.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from functools import cache, lru_cache
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError
from pydantic_core import to_json

from tca_bus._errors import InvalidMessageError
from tca_bus._problems import problems_of

_HEADER_LENGTH = struct.Struct("<I")


class _ArrayHeader(BaseModel):
    model_config = ConfigDict(extra="forbid")

    name: str
    dtype: Annotated[str, Field(pattern=r"^[<|](f[248]|[iu][1248]|b1)$")]
    length: Annotated[int, Field(ge=0, le=1 << 28)]


class _FrameHeader(BaseModel):
    model_config = ConfigDict(extra="forbid")

    fields: dict[str, Any]
    arrays: list[_ArrayHeader]


_arrays = TypeAdapter(list[_ArrayHeader])

_number_type = cache(np.dtype)
"""Of the few kinds of number that a header may name."""

_read_fields = TypeAdapter(dict[str, Any]).validator.validate_json

_FIELDS_FIRST, _ARRAYS_LAST = b'{"fields":', b',"arrays":'
"""How a header is written here; any other order, or space, is as good."""

MOST_KNOWN = 4096
"""Bytes of what a header says of arrays, of which it is remembered what they mean."""


def encode_frame(model: BaseModel, kinds: Mapping[str, str]) -> bytes:
    """Encode a model whose fields named in ``kinds`` are arrays of those number types."""
    arrays = {
        name: np.ascontiguousarray(getattr(model, name), kind) for name, kind in kinds.items()
    }
    plain = model.__pydantic_serializer__.to_python(model, mode="json", exclude=set(kinds))
    fields = to_json(plain, inf_nan_mode="constants")
    described = _describe(tuple((name, kinds[name], len(one)) for name, one in arrays.items()))
    text = b"%b%b%b%b}" % (_FIELDS_FIRST, fields, _ARRAYS_LAST, described)
    return b"".join(
        [_HEADER_LENGTH.pack(len(text)), text, *(one.tobytes() for one in arrays.values())]
    )


@lru_cache(maxsize=256)
def _describe(arrays: tuple[tuple[str, str, int], ...]) -> bytes:
    """What the header says of arrays; those of one message type rarely change in length."""
    facts = ((name, _number_type(kind).str, size) for name, kind, size in arrays)
    return to_json([{"name": name, "dtype": kind, "length": size} for name, kind, size in facts])


def decode_frame(data: bytes, name: str) -> dict[str, Any]:
    """Take a frame of the message ``name`` apart into its fields.

    Raises:
        InvalidMessageError: It is no frame, or one that is cut off or too long.
    """
    fields, arrays, offset = _read_header(data, name)
    for entry in arrays:
        array, length = entry.name, entry.length
        dtype = _number_type(entry.dtype)
        end = offset + length * dtype.itemsize
        if end > len(data):
            problem = f"{array}: expected {end} bytes of frame, got {len(data)}"
            raise InvalidMessageError(name, [problem])
        fields[array] = np.frombuffer(data, dtype, length, offset)
        offset = end
    if offset != len(data):
        problem = f"frame: expected {offset} bytes, got {len(data)}"
        raise InvalidMessageError(name, [problem])
    return fields


def decode_frame_plain(data: bytes, name: str) -> dict[str, Any]:
    """Take a frame apart, with lists in place of arrays.

    Raises:
        InvalidMessageError: As for `decode_frame`.
    """
    return {
        key: value.tolist() if isinstance(value, np.ndarray) else value
        for key, value in decode_frame(data, name).items()
    }


def _read_header(data: bytes, name: str) -> tuple[dict[str, Any], Sequence[_ArrayHeader], int]:
    """The fields, what is said of the arrays, and where these begin."""
    size = _HEADER_LENGTH.size
    if len(data) < size:
        raise InvalidMessageError(name, [f"frame: expected at least {size} bytes, got {len(data)}"])
    end = size + _HEADER_LENGTH.unpack_from(data)[0]
    if end > len(data):
        raise InvalidMessageError(name, [f"frame: header of {end} bytes in {len(data)}"])
    text = data[size:end]
    if (known := _read_known(text)) is not None:
        return *known, end
    try:
        header = _FrameHeader.model_validate_json(text)
    except ValidationError as error:
        raise InvalidMessageError(name, problems_of(error)) from error
    return header.fields, header.arrays, end


def _read_known(text: bytes) -> tuple[dict[str, Any], Sequence[_ArrayHeader]] | None:
    """A header as it is written here, whose arrays are the same in each message of a type.

    None for any other. Within texts quotes are escaped: both parts are whole JSON values only where
    the text is an object of these two.
    """
    first, _, last = text.rpartition(_ARRAYS_LAST)
    if not (first.startswith(_FIELDS_FIRST) and last.endswith(b"}") and len(last) <= MOST_KNOWN):
        return None
    try:
        return _read_fields(first[len(_FIELDS_FIRST) :]), _read_arrays(last[:-1])
    except ValidationError:
        return None


@lru_cache(maxsize=256)
def _read_arrays(text: bytes) -> Sequence[_ArrayHeader]:
    return tuple(_arrays.validate_json(text))
