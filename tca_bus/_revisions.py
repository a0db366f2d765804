"""Messages of other revisions: what is understood, what is refused, and how it is answered.

A field that is added with a default keeps the revision. So data of this revision may have fields
that this module does not know yet, if a newer module sent them: they are left out. Data of another
revision are understood if the message type accepts it; the type upgrades them, and puts the answer
into the sender's form.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from pydantic import ValidationError

from tca_bus._errors import InvalidMessageError
from tca_bus._messages import Message
from tca_bus._problems import problems_of
from tca_bus._types import message_adapter

logger = logging.getLogger(__name__)

EXTRA_FIELD = "extra_forbidden"
"""What pydantic calls a field that a type does not have."""


def understand(
    message_type: type[Message],
    told: int | str | None,
    *,
    validate: Callable[[], Any],
    plain: Callable[[], Any],
) -> Message:
    """Make a message of data that arrived.

    Args:
        message_type: What it should be.
        told: The revision that the sender says it is of; None where it says nothing, and then the
            data have to fit exactly.
        validate: Validates the data as they came.
        plain: Gives them as JSON values.

    Raises:
        InvalidMessageError: They do not fit; if it is a matter of revisions the error names both,
            and the fields that are in the way.
        ValidationError: They do not fit, and told no other revision.
    """
    if told is None:
        return validate()  # type: ignore[no-any-return]
    if told == message_type.revision:
        return _of_this_revision(message_type, validate, plain)
    if isinstance(told, int) and told in message_type.accepts:
        return _of_accepted_revision(message_type, told, plain)
    raise _refusal(message_type, told, validate)


def answer_for(message_type: type[Message], told: int | None, answer: Any) -> tuple[Any, int]:
    """An answer, as JSON values, in the form for a sender, and the revision that it is of then."""
    if told is None or told == message_type.revision or told not in message_type.accepts:
        return answer, message_type.revision
    return message_type.downgrade_answer(told, answer), told


def _of_this_revision(
    message_type: type[Message], validate: Callable[[], Any], plain: Callable[[], Any]
) -> Message:
    try:
        return validate()  # type: ignore[no-any-return]
    except ValidationError as error:
        unknown = [problem["loc"] for problem in error.errors(include_url=False)]
        if any(problem["type"] != EXTRA_FIELD for problem in error.errors(include_url=False)):
            raise
        data = plain()
        if not all(_leave_out(data, place) for place in unknown):
            raise
    names = ", ".join(".".join(map(str, place)) for place in unknown)
    logger.debug("fields of a newer %s are left out: %s", message_type.wire_name, names)
    return message_adapter(message_type).validate_python(data)


def _of_accepted_revision(
    message_type: type[Message], told: int, plain: Callable[[], Any]
) -> Message:
    name = message_type.wire_name
    try:
        return message_adapter(message_type).validate_python(message_type.upgrade(told, plain()))
    except ValidationError as error:
        problems = problems_of(error)
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        problems = [f"its upgrade failed: {type(error).__name__}: {error}"]
    first = f"revision: {told} could not be upgraded to {message_type.revision}"
    raise InvalidMessageError(name, [first, *problems])


def _refusal(
    message_type: type[Message], told: int | str, validate: Callable[[], Any]
) -> InvalidMessageError:
    """Why another revision is not understood: both numbers, and the fields in the way."""
    accepted = sorted({message_type.revision, *message_type.accepts})
    problems = [f"revision: expected {_or(accepted)}, got {told!r}"]
    try:
        validate()
    except ValidationError as error:
        problems += problems_of(error)
    except InvalidMessageError as error:
        problems += error.problems
    return InvalidMessageError(message_type.wire_name, problems)


def _leave_out(data: Any, place: tuple[int | str, ...]) -> bool:
    """Remove one field from nested data; False if it is not found there."""
    for step in place[:-1]:
        try:
            data = data[step]
        except (LookupError, TypeError):
            return False
    if not isinstance(data, dict) or place[-1] not in data:
        return False
    del data[place[-1]]
    return True


def _or(numbers: list[int]) -> str:
    return " or ".join(map(str, numbers))
