"""Errors as values: how they cross the bus and come out as the same class.

An error reply is ``{"error": kind, ...facts}``, e.g. ``{"error": "no_handler", "message": ..,
"known": [..]}``.
"""

from __future__ import annotations

import json
from typing import Any

from pydantic import TypeAdapter

from tca_bus._errors import (
    AtCapacityError,
    BusGoneError,
    BusyError,
    ClosedError,
    ConfigError,
    HandlerFailedError,
    InvalidMessageError,
    KilledError,
    NeverSetError,
    NoHandlerError,
    PeerLostError,
    RefusedError,
    TaskError,
    TaskFailedError,
    TcaError,
    TimedOutError,
    VariableChangedError,
)
from tca_bus._failure import Failure
from tca_bus._wire import Payload

ERROR_TYPE = "application/json;tca.error@1"

FAILURE_NAMES: dict[type[TcaError], str] = {
    AtCapacityError: "busy",
    BusGoneError: "bus_gone",
    BusyError: "busy",
    ClosedError: "closed",
    ConfigError: "config",
    InvalidMessageError: "invalid_message",
    KilledError: "killed",
    NeverSetError: "never_set",
    NoHandlerError: "no_handler",
    PeerLostError: "peer_lost",
    RefusedError: "refused",
    TimedOutError: "timed_out",
    VariableChangedError: "variable_changed",
}
"""The failure names of bus errors that end a handler."""

SAME_CLASS: dict[str, tuple[type[TcaError], dict[str, str]]] = {
    "no_handler": (NoHandlerError, {"message": "message", "known": "near"}),
    "invalid": (InvalidMessageError, {"message": "message", "problems": "problems"}),
    "refused": (RefusedError, {"what": "what", "why": "why"}),
    "busy": (BusyError, {"what": "what", "why": "why"}),
    "at_capacity": (AtCapacityError, {"what": "what", "why": "why"}),
    "timed_out": (TimedOutError, {"what": "what", "seconds": "seconds"}),
    "killed": (KilledError, {"task": "task", "reason": "reason"}),
    "peer_lost": (PeerLostError, {"module": "module", "what": "what"}),
    "never_set": (NeverSetError, {"name": "name", "known": "near"}),
    "variable_changed": (
        VariableChangedError,
        {"name": "name", "expected": "expected", "found": "found"},
    ),
}
"""Kinds of error replies that come out as the class that went in: the class, and for each
argument of it the attribute that has its value."""

FAILED = "failed"
"""The kind of error reply of anything else that a handler raised; it has a ``failure``."""

HANDLER_ERROR = "handler_error"
"""The failure name of an exception that is not one of ours."""

_FACTS = TypeAdapter(dict[str, Any])


def failure_of(
    error: BaseException, *, message: str, module: str, node: str | None = None
) -> Failure:
    """Turn what a handler raised into a failure; a sub-task's failure becomes its cause.

    What cannot be sent, such as data that are no JSON, is a ``handler_error`` that says so.
    """
    facts: dict[str, Any] = {"message": message, "module": module, "node": node}
    try:
        failure = _failure_of(error, facts)
        failure.model_dump_json()
    except ValueError as problem:
        text = f"{type(error).__name__}: {error} (it cannot be sent as it is: {problem})"
        sendable = text.encode(errors="backslashreplace").decode()
        return Failure(name=HANDLER_ERROR, text=sendable, **facts)
    return failure


def _failure_of(error: BaseException, facts: dict[str, Any]) -> Failure:
    match error:
        case TaskError():
            return Failure(
                name=error.name, text=str(error), data=error.data, kinds=error.kinds, **facts
            )
        case TaskFailedError(task=task, failure=cause):
            same = {"name": cause.name, "kinds": cause.kinds, "uncaught": cause.uncaught}
            return Failure(text=f"task {task} failed", cause=cause, **same, **facts)
        case HandlerFailedError(failure=cause):
            return Failure(name=cause.name, text=f"{cause.message} failed", cause=cause, **facts)
        case TcaError():
            name = FAILURE_NAMES.get(type(error), HANDLER_ERROR)
            return Failure(name=name, text=str(error), **facts)
    return Failure(name=HANDLER_ERROR, text=f"{type(error).__name__}: {error}", **facts)


def encode_error(error: BaseException, *, message: str, module: str) -> Payload:
    """Encode what a query's handler raised as an error reply."""
    facts = _facts_of(error)
    if facts is None:
        failure = failure_of(error, message=message, module=module)
        facts = {"error": FAILED, "failure": failure.model_dump(mode="json")}
    return Payload(json.dumps(facts).encode(), ERROR_TYPE)


def decode_error(payload: Payload, *, message: str) -> TcaError:
    """The error that an error reply stands for."""
    try:
        facts = _FACTS.validate_json(payload.data)
        return _error_of(facts)
    except (AttributeError, KeyError, TypeError, ValueError):
        shown = payload.data[:200].decode(errors="replace")
        return InvalidMessageError(message, [f"error reply: expected an error, got {shown!r}"])


def _facts_of(error: BaseException) -> dict[str, Any] | None:
    """What an error that keeps its class says of itself; None for any other."""
    for kind, (error_class, facts) in SAME_CLASS.items():
        if type(error) is error_class:
            values = {argument: getattr(error, name) for argument, name in facts.items()}
            return {"error": kind, **values}
    return None


def _error_of(facts: dict[str, Any]) -> TcaError:
    kind = facts.pop("error")
    if kind == FAILED:
        return HandlerFailedError(Failure.model_validate(facts["failure"]))
    error_class, _ = SAME_CLASS[kind]
    return error_class(**facts)
