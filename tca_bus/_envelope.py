"""What rides beside each payload, in the attachment: request id, sender, task, trace."""

from __future__ import annotations

import itertools
import random
import re
import secrets
from contextvars import ContextVar
from hashlib import blake2b
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
    whose handler the message was sent, ``traceparent`` the W3C trace context in which it was
    sent; what was sent outside of any begins one, see `trace`.
    """

    model_config = ConfigDict(frozen=True, extra="ignore")

    id: str = Field(min_length=1, max_length=200)
    sender: str = Field(default="", max_length=200)
    task: str | None = Field(default=None, max_length=200)
    traceparent: str | None = Field(default=None, pattern=TRACEPARENT_PATTERN)

    @property
    def trace(self) -> str:
        """The W3C trace context to go on from: the one that it has, or one made of its id.

        Whoever receives a message finds the same trace, though nobody sent it.
        """
        if self.traceparent is not None:
            return self.traceparent
        digest = blake2b(self.id.encode(), digest_size=24).hexdigest()
        return f"00-{digest[:32]}-{digest[32:]}-01"


handled: ContextVar[Envelope | None] = ContextVar("handled", default=None)
"""The envelope of what the running handler handles."""

_ENVELOPES = TypeAdapter(Envelope)


class Stamp(NamedTuple):
    """The id of a new message, and its attachment."""

    id: str
    attachment: bytes


def new_stamp(sender: str) -> Stamp:
    """Make an id and an envelope for a new message from an incarnation.

    Task and trace go on from the running handler.
    """
    # An incarnation is unique, so with a number it names one message for ever.
    id = f"{sender}.{next(_numbers):x}"
    inside = handled.get()
    if inside is None:
        return Stamp(id, f'{{"id":"{id}","sender":"{sender}"}}'.encode())
    trace = next_traceparent(inside.trace)
    envelope = {"id": id, "sender": sender, "task": inside.task, "traceparent": trace}
    return Stamp(id, to_json(envelope))


def read_envelope(attachment: bytes | None) -> Envelope:
    """Read an attachment; a message without one (from a plain Zenoh tool) gets a new envelope.

    Raises:
        InvalidMessageError: The attachment is no envelope.
    """
    if attachment is None:
        return Envelope(id=secrets.token_hex(12))
    try:
        return _ENVELOPES.validator.validate_json(attachment)  # type: ignore[no-any-return]
    except ValidationError as error:
        raise InvalidMessageError("attachment", problems_of(error)) from error


def next_traceparent(parent: str) -> str:
    """A span of its own in the trace of another."""
    return f"00-{parent.split('-')[1]}-{_chance.getrandbits(64):016x}-01"
