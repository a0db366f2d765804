"""What rides beside each payload, in the attachment: request id, sender, task, trace."""

from __future__ import annotations

import itertools
import random
import re
import secrets
from contextvars import ContextVar
from typing import NamedTuple

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError
from pydantic_core import to_json

from tca_bus._errors import InvalidMessageError
from tca_bus._problems import problems_of

TRACEPARENT_PATTERN = r"^[0-9a-f]{2}-[0-9a-f]{32}-[0-9a-f]{16}-[0-9a-f]{2}$"

INCARNATION_PATTERN = re.compile(r"[A-Za-z0-9._-]{1,100}")
"""What a sender's incarnation has to be for an answer to find the way back: one chunk of a key."""

_numbers = itertools.count(1)
_chance = random.Random(secrets.randbits(128))


class Envelope(BaseModel):
    """The attachment, as JSON.

    ``sender`` is the sending incarnation; who it is stands in the key. ``task`` is the task in
    whose handler the message was sent, ``traceparent`` the W3C trace context.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    id: str = Field(min_length=1, max_length=200)
    sender: str = Field(default="", max_length=200)
    task: str | None = Field(default=None, max_length=200)
    traceparent: str | None = Field(default=None, pattern=TRACEPARENT_PATTERN)


handled: ContextVar[Envelope | None] = ContextVar("handled", default=None)
"""The envelope of what the running handler handles."""

_ENVELOPES = TypeAdapter(Envelope)


class Stamp(NamedTuple):
    """The id of a new message, and its attachment."""

    id: str
    attachment: bytes


def new_stamp(sender: str) -> Stamp:
    """What `new_envelope` makes, as it is sent."""
    inside = handled.get()
    id = _new_id(sender)
    trace = _next_traceparent(inside.traceparent if inside else None)
    # Ids and traces are of letters that JSON takes as they are; a task's id is its sender's.
    task = f',"task":{to_json(inside.task).decode()}' if inside and inside.task else ""
    return Stamp(id, f'{{"id":"{id}","sender":"{sender}","traceparent":"{trace}"{task}}}'.encode())


def new_envelope(sender: str) -> Envelope:
    """An envelope for a new message; task and trace go on from the running handler."""
    inside = handled.get()
    return Envelope.model_construct(
        id=_new_id(sender),
        sender=sender,
        task=inside.task if inside else None,
        traceparent=_next_traceparent(inside.traceparent if inside else None),
    )


def read_envelope(attachment: bytes | None) -> Envelope:
    """Read an attachment; a message without one (from a plain Zenoh tool) gets a new envelope.

    Raises:
        InvalidMessageError: The attachment is no envelope.
    """
    if attachment is None:
        return new_envelope("")
    try:
        return _ENVELOPES.validator.validate_json(attachment)  # type: ignore[no-any-return]
    except ValidationError as error:
        raise InvalidMessageError("attachment", problems_of(error)) from error


def _new_id(sender: str) -> str:
    """An incarnation is unique, so with a number it names one message for ever."""
    return f"{sender}.{next(_numbers):x}" if sender else secrets.token_hex(12)


def _next_traceparent(parent: str | None) -> str:
    chance = f"{_chance.getrandbits(192):048x}"
    trace = parent.split("-")[1] if parent else chance[16:]
    return f"00-{trace}-{chance[:16]}-01"
