"""What rides beside each payload, in the attachment: request id, sender, task, trace."""

from __future__ import annotations

import itertools
import re
import secrets
from contextvars import ContextVar
from typing import NamedTuple

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError
from pydantic_core import to_json

from tca_bus._errors import InvalidMessageError
from tca_bus._problems import problems_of
from tca_bus._trace_context import TRACEPARENT_PATTERN, active_traceparent, adopt


class Envelope(BaseModel):
    """The attachment, as JSON.

    ``sender`` is the sending incarnation; who it is stands in the key. ``task`` is the task in
    whose handler the message was sent, ``traceparent`` the W3C trace context: the span that it
    was sent from, None when there is none.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    id: str = Field(min_length=1, max_length=200)
    sender: str = Field(default="", max_length=200)
    task: str | None = Field(default=None, max_length=200)
    traceparent: str | None = Field(default=None, pattern=TRACEPARENT_PATTERN)


handled: ContextVar[Envelope | None] = ContextVar("handled", default=None)
"""The envelope of what the running handler handles."""

INCARNATION_PATTERN = re.compile(r"[A-Za-z0-9._-]{1,100}")
"""What a sender's incarnation has to be for an answer to find the way back: one chunk of a key."""

_validate = TypeAdapter(Envelope).validator.validate_json

_numbers = itertools.count(1)


class Stamp(NamedTuple):
    """The id of a new message, and its attachment."""

    id: str
    attachment: bytes


def new_stamp(sender: str) -> Stamp:
    """Make an id and an attachment for a new message from an incarnation; see `new_envelope`."""
    # An incarnation is unique, so with a number it names one message for ever.
    id = f"{sender}.{next(_numbers):x}"
    inside = handled.get()
    task = None if inside is None else inside.task
    trace = active_traceparent() or (None if inside is None else inside.traceparent)
    if task is None and trace is None:
        return Stamp(id, f'{{"id":"{id}","sender":"{sender}"}}'.encode())
    facts = {"id": id, "sender": sender, "task": task, "traceparent": trace}
    return Stamp(id, to_json({name: fact for name, fact in facts.items() if fact is not None}))


def new_envelope(sender: str) -> Envelope:
    """An envelope for a new message; task and trace go on from the running handler."""
    inside = handled.get()
    return Envelope.model_construct(
        id=secrets.token_hex(12),
        sender=sender,
        task=inside.task if inside else None,
        traceparent=sending_traceparent(),
    )


def read_envelope(attachment: bytes | None) -> Envelope:
    """Read an attachment; a message without one (from a plain Zenoh tool) gets a new envelope.

    Raises:
        InvalidMessageError: The attachment is no envelope.
    """
    if attachment is None:
        return new_envelope("")
    try:
        return _validate(attachment)  # type: ignore[no-any-return]
    except ValidationError as error:
        raise InvalidMessageError("attachment", problems_of(error)) from error


def begin_handling(envelope: Envelope) -> None:
    """Let what the running task of the loop sends from here on go on from a message."""
    handled.set(envelope)
    if envelope.traceparent is not None:
        adopt(envelope.traceparent)


def sending_traceparent() -> str | None:
    """The span that what is sent now is sent from: the active one, or that of the handled task."""
    inside = handled.get()
    return active_traceparent() or (inside.traceparent if inside else None)
