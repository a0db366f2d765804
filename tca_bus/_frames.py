"""Frames: a JSON header and raw arrays, for messages with array fields.

A frame is: header length (u32, little endian), header (JSON), arrays one after the other. The
header is ``{"fields": {...}, "arrays": [{"name": .., "dtype": "<f4", "length": 24}, ..]}``;
arrays are little endian, one-dimensional.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from functools import cache, lru_cache
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError
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


_number_type = cache(np.dtype)
"""Of the few kinds of number that a header may name."""


def encode_frame(model: BaseModel, kinds: Mapping[str, str]) -> bytes:
    """Encode a model whose fields named in ``kinds`` are arrays of those number types."""
    arrays = {
        name: np.ascontiguousarray(getattr(model, name), kind) for name, kind in kinds.items()
    }
    plain = model.__pydantic_serializer__.to_python(model, mode="json", exclude=set(kinds))
    fields = to_json(plain, inf_nan_mode="constants")
    text = b'{"fields":%b,"arrays":%b}' % (fields, _described(arrays))
    return b"".join(
        [_HEADER_LENGTH.pack(len(text)), text, *(one.tobytes() for one in arrays.values())]
    )


def _described(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """What the header says of the arrays; those of one message type rarely change in length."""
    return _describe(tuple((name, one.dtype.str, len(one)) for name, one in arrays.items()))


@lru_cache(maxsize=256)
def _describe(arrays: tuple[tuple[str, str, int], ...]) -> bytes:
    return to_json([{"name": n, "dtype": kind, "length": size} for n, kind, size in arrays])


def decode_frame(data: bytes, name: str) -> dict[str, Any]:
    """Take a frame of the message ``name`` apart into its fields.

    Raises:
        InvalidMessageError: It is no frame, or one that is cut off or too long.
    """
    header, offset = _read_header(data, name)
    fields = header.fields
    for entry in header.arrays:
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
