"""A task as central gives it, read as the message that its handler takes; and its result."""

from __future__ import annotations

from copy import deepcopy
from typing import Any

from pydantic import ValidationError

from tca_bus._attachments import Caught
from tca_bus._errors import InvalidMessageError, NoHandlerError, TaskError
from tca_bus._failure import Failure
from tca_bus._handlers import TASKS, Handler, Handlers
from tca_bus._messages import Message, MessageClass
from tca_bus._problems import problems_of
from tca_bus._protocol import HandleTask
from tca_bus._revisions import answer_for, understand
from tca_bus._types import answer_adapter


def read_task(handlers: Handlers, task: HandleTask) -> tuple[Message, Handler]:
    """The message of a task as its type, and the handler that takes it here.

    Raises:
        NoHandlerError: this module handles no such thing.
        InvalidMessageError: the task is of another class, or its data do not fit.
    """
    handler = handlers.get(task.name)
    if handler is None or not _fits(handler, task):
        raise NoHandlerError(task.name, handlers.provided())
    kind = handler.message_type
    if task.task_class == "exception":
        return _exception(kind, task), handler
    if kind.message_class in TASKS and kind.message_class.value != task.task_class:
        problem = f"class: expected {kind.message_class.value}, got {task.task_class}"
        raise InvalidMessageError(task.name, [problem])
    try:
        message = understand(
            kind,
            task.message_revision,
            validate=lambda: kind.model_validate(task.data),
            plain=lambda: deepcopy(task.data),
        )
    except ValidationError as error:
        raise InvalidMessageError(task.name, problems_of(error)) from error
    return message, handler


def plain_result(value: Any, handler: Handler, told: int | None) -> Any:
    """The result as JSON values, in the sender's form; one of another type is a failure."""
    adapter = answer_adapter(handler.message_type)
    try:
        result = adapter.dump_python(adapter.validate_python(value), mode="json")
    except ValidationError as error:
        raise TaskError("invalid_result", f"result: {'; '.join(problems_of(error))}") from error
    return answer_for(handler.message_type, told, result)[0]


def _fits(handler: Handler, task: HandleTask) -> bool:
    """Whether the handler of that name can be meant."""
    kind = handler.message_type.message_class
    if task.task_class == "exception":
        return kind == MessageClass.EXCEPTION
    if task.monitor is not None:
        return kind == (MessageClass.DEMON if task.monitor.kind == "demon" else MessageClass.QUERY)
    return kind in TASKS


def _exception(kind: type[Message], task: HandleTask) -> Message:
    """The exception that a handler of it is given; one of any kind is given without data."""
    failure = Failure.model_validate(Caught.model_validate(task.data).failure)
    try:
        if kind.wire_name in {failure.name, *failure.kinds}:
            known = failure.data or {}
            fields = {name: known[name] for name in kind.model_fields if name in known}
            return kind.model_validate(fields)
        return kind()
    except ValidationError as error:
        raise InvalidMessageError(task.name, problems_of(error)) from error
