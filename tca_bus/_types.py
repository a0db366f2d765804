"""What a message type says about itself: its answer type and its array fields."""

from __future__ import annotations

from functools import cache
from typing import Any

from pydantic import BaseModel, TypeAdapter

from tca_bus._messages import Message, MultiQuery, Query, TaskMessage

ANSWERED = (Query, MultiQuery, TaskMessage)


class ArrayMark:
    """Marks a field that travels as a binary array of ``number_type``, such as ``<f4``."""

    def __init__(self, number_type: str) -> None:
        self.number_type = number_type


@cache
def answer_type(message_type: type[Message]) -> Any:
    """The reply or result type of a message type; ``Any`` when it names none.

    ``class Where(Query[Place])`` gives ``Place``.
    """
    for base in message_type.__mro__:
        generic = getattr(base, "__pydantic_generic_metadata__", {})
        if generic.get("args") and issubclass(base, ANSWERED):
            return generic["args"][0]
    return Any


@cache
def answer_adapter(message_type: type[Message]) -> TypeAdapter[Any]:
    """A validator and serialiser of the answers to a message type."""
    return TypeAdapter(answer_type(message_type))


@cache
def message_adapter(message_type: type[Message]) -> TypeAdapter[Message]:
    """A validator of messages of one type."""
    return TypeAdapter(message_type)


@cache
def message_schema(message_type: type[Message]) -> dict[str, Any]:
    """The JSON schema of a message type; not to be changed."""
    return message_type.model_json_schema()


@cache
def answer_schema(message_type: type[Message]) -> dict[str, Any]:
    """The JSON schema of the answers to a message type; not to be changed."""
    return answer_adapter(message_type).json_schema()


@cache
def array_fields(value_type: Any) -> dict[str, str]:
    """The fields of a model that travel as binary arrays, with their number types."""
    if not (isinstance(value_type, type) and issubclass(value_type, BaseModel)):
        return {}
    return {
        name: mark.number_type
        for name, field in value_type.model_fields.items()
        for mark in field.metadata
        if isinstance(mark, ArrayMark)
    }


def summary(described: Any) -> str:
    """The first line of a docstring, without the marks of code."""
    lines = (described.__doc__ or "").strip().splitlines()
    return lines[0].replace("`", "") if lines else ""
