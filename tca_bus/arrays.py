"""Arrays of numbers in messages: checked on arrival, binary on the wire, lists in JSON."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import core_schema

from tca_bus._types import ArrayMark


class ArrayField(ArrayMark):
    """Marks a field as a one-dimensional array of one little-endian number type."""

    def __init__(self, number_type: str) -> None:
        super().__init__(number_type)
        self.dtype = np.dtype(number_type)

    def __get_pydantic_core_schema__(
        self, source: object, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        """Validate lists and arrays alike; serialise to a list in JSON only."""
        del source, handler
        return core_schema.no_info_plain_validator_function(
            self._validate,
            serialization=core_schema.plain_serializer_function_ser_schema(
                lambda array: array.tolist(), when_used="json"
            ),
        )

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """Describe the array as a list of numbers."""
        del schema, handler
        return {"type": "array", "items": {"type": "number"}, "format": self.dtype.str}

    def _validate(self, value: Any) -> NDArray[Any]:
        if isinstance(value, np.ndarray) and value.dtype == self.dtype and value.ndim == 1:
            return value
        try:
            with np.errstate(over="raise", invalid="raise"):
                array = np.asarray(value, dtype=self.dtype)
        except (ArithmeticError, TypeError, ValueError) as error:
            raise ValueError(f"expected a list of numbers: {error}") from error
        if array.ndim != 1:
            raise ValueError(f"expected one dimension, got shape {array.shape}")
        return array


Float32Array = Annotated[NDArray[np.float32], ArrayField("<f4")]
"""A one-dimensional array of 32-bit floats, whose length the message's docstring gives."""
