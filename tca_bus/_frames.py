"""Frames: a JSON header and raw arrays, for messages with array fields.

A frame is: header length (u32, little endian), header (JSON), arrays one after the other. The
header is ``{"fields": {...}, "arrays": [{"name": .., "dtype": "<f4", "length": 24}, ..]}``;
arrays are little endian, one-dimensional.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

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


def encode_frame(model: BaseModel, kinds: Mapping[str, str]) -> bytes:
    """Encode a model whose fields named in ``kinds`` are arrays of those number types."""
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


def decode_frame(data: bytes, name: str) -> dict[str, Any]:
    """Take a frame of the message ``name`` apart into its fields.

    Raises:
        InvalidMessageError: It is no frame, or one that is cut off or too long.
    """
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
