"""What a command that failed says, and its exit code."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from typing import Any

from pydantic import ValidationError

from tca_bus._errors import InvalidMessageError, TcaError
from tca_bus._problems import problems_of

logger = logging.getLogger(__name__)


def complain(error: BaseException) -> int:
    """Say in a line what is wrong, for an error of the house; the exit code that stands for it.

    Raises:
        BaseException: ``error`` itself, when it is none of ours; a broken pipe in a group, alone.
    """
    if isinstance(error, ValidationError):
        # A message that was made of what the user typed; -v shows where.
        logger.debug("no valid message", exc_info=error)
        return _say(InvalidMessageError(error.title, problems_of(error)))
    if isinstance(error, BaseExceptionGroup):
        found = next(_errors_in(error), None)
        if found is not None:
            return _say(found)
    if isinstance(error, TcaError):
        return _say(error)
    raise error


def _say(error: TcaError) -> int:
    sys.stderr.write(f"error: {error}\n")
    return error.exit_code


def _errors_in(group: BaseExceptionGroup[Any]) -> Iterator[TcaError]:
    for error in group.exceptions:
        if isinstance(error, TcaError | BrokenPipeError):
            if isinstance(error, BrokenPipeError):
                raise error
            yield error
        elif isinstance(error, BaseExceptionGroup):
            yield from _errors_in(error)
