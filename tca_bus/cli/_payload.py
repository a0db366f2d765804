"""The JSON that people type for a message."""

from __future__ import annotations

import json
import sys
from typing import Annotated, Any, NoReturn

from cyclopts import Parameter

from tca_bus import InvalidMessageError
from tca_bus._protocol import ProvidedMessage
from tca_bus._schema import schema_problems

JsonText = Annotated[str, Parameter(allow_leading_hyphen=True)]
"""The argument itself: JSON, or ``-`` for standard input."""


def parse_payload(name: str, text: str) -> dict[str, Any]:
    """Read the fields of a message; ``-`` reads them from standard input.

    Raises:
        InvalidMessageError: it is no JSON (with line and column), or no object.
    """
    value = parse_value(name, text)
    if not isinstance(value, dict):
        shown = json.dumps(value)[:60]
        problem = f'expected a JSON object such as {{"field": 1}}, got {shown!r}'
        raise InvalidMessageError(name, [problem])
    return value


def parse_value(name: str, text: str) -> Any:
    """Read any JSON value; ``-`` reads it from standard input.

    Raises:
        InvalidMessageError: it is no JSON (with line and column).
    """
    source = sys.stdin.read() if text == "-" else text
    try:
        return json.loads(source, parse_constant=_refuse_constant)
    except (ValueError, RecursionError) as error:
        raise InvalidMessageError(name, [f"no JSON: {_what_is_wrong(error, source)}"]) from None


def check_payload(provided: ProvidedMessage | None, name: str, data: dict[str, Any]) -> None:
    """Refuse data that do not fit the schema that the handling module shows.

    Raises:
        InvalidMessageError: fields are missing, unknown or of a wrong type.
    """
    if provided is None:
        return
    problems = schema_problems(data, provided.message_schema)
    if problems:
        raise InvalidMessageError(name, problems)


def check_class(provided: ProvidedMessage | None, name: str, expected: str) -> None:
    """Refuse a message that is of another class than the command sends.

    Raises:
        InvalidMessageError: it is; the error names the command to use.
    """
    if provided is None:
        return
    kind = provided.message_class.removeprefix("multi_")
    if kind != expected:
        problem = f"its class is {kind}, not {expected}; use 'tca {kind} {name}'"
        raise InvalidMessageError(name, [problem])


def _refuse_constant(text: str) -> NoReturn:
    raise ValueError(f"{text} is no number that JSON knows")


def _what_is_wrong(error: Exception, source: str) -> str:
    if isinstance(error, json.JSONDecodeError):
        near = source[max(0, error.pos - 20) : error.pos + 20]
        return f"{error.msg} at line {error.lineno} column {error.colno}, near {near!r}"
    if isinstance(error, RecursionError):
        return "it is nested too deep"
    return str(error)
