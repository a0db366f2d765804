"""The robot's messages and the names they have in a recording."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ValidationError

from tca_bus import InvalidMessageError, Message, Payload, Query, decode_message, encode_message
from xavier_sim import messages
from xavier_sim.messages import PlateReading, ReadPlate, TrueLocation, WhereReally

REPLY = ".reply"

ANSWERS: dict[type[BaseModel], type[Query[Any]]] = {
    PlateReading: ReadPlate,
    TrueLocation: WhereReally,
}
"""Answers that are recorded, and the questions that they answer."""

_BY_NAME: dict[str, type[BaseModel]] = {
    **{
        kind.wire_name: kind
        for kind in (getattr(messages, name) for name in messages.__all__)
        if isinstance(kind, type) and issubclass(kind, Message)
    },
    **{question.wire_name + REPLY: answer for answer, question in ANSWERS.items()},
}


def wire_name(kind: type[BaseModel]) -> str:
    """The name of a message of the robot, or of an answer of `ANSWERS`."""
    if issubclass(kind, Message):
        return kind.wire_name
    return ANSWERS[kind].wire_name + REPLY


def encode(message: BaseModel) -> Payload:
    """The message as it goes over the wire."""
    if isinstance(message, Message):
        return encode_message(message)
    question = ANSWERS[type(message)]
    told = f"application/json;{question.wire_name}{REPLY}@{question.revision}"
    return Payload(message.model_dump_json().encode(), told)


def decode(name: str, payload: Payload) -> BaseModel | None:
    """The message that a payload is; None for a name that this robot does not know.

    Raises:
        InvalidMessageError: It is not what its name says, or of a version that is not understood.
    """
    kind = _BY_NAME.get(name)
    if kind is None:
        return None
    if issubclass(kind, Message):
        return decode_message(payload, kind)
    try:
        return kind.model_validate_json(payload.data)
    except ValidationError as error:
        problems = [f"{error.error_count()} fields do not fit"]
        raise InvalidMessageError(name, problems) from error
