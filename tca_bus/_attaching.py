"""Taps, exception handlers and clean-ups as callers make them, and how they hold them."""

from __future__ import annotations

import uuid
from collections.abc import Awaitable, Callable
from typing import Any, Literal, Self

from tca_bus._attachments import (
    ANY,
    Attachment,
    Catch,
    CleanUp,
    Sending,
    Tap,
    TapCondition,
    TapNotice,
)
from tca_bus._errors import ConfigError, near_matches
from tca_bus._messages import Broadcast, Goal, Inform, Message, TaskMessage, TcaException
from tca_bus._traits import traits_of

SENDABLE = (TaskMessage, Inform, Broadcast)
"""What central may send on behalf of somebody."""


def tap(
    condition: TapCondition | str,
    listener: type[Message] | Message,
    *,
    on_failure: Literal["ignore", "fail"] = "ignore",
    priority: int | None = None,
    id: str | None = None,
) -> Tap:
    """A tap: ``listener`` is sent when something tapped comes to ``condition``.

    The listener is given the tapped message's data, so a type must have the same fields; a type
    that is a `TapNotice` too is told more. A goal or command in a blocking tap holds the tapped
    task until it is achieved; with ``on_failure="fail"`` its failure fails the tapped task.

    Raises:
        ConfigError: There is no such condition, or the listener is a query.
    """
    kind: type[Any] = listener if isinstance(listener, type) else type(listener)
    return Tap(
        id=id or _new_id("tap"),
        condition=_condition(condition),
        listener=sending(listener, priority=priority),
        payload="notice" if issubclass(kind, TapNotice) else "data",
        on_failure=on_failure,
    )


def catch(
    exception: type[TcaException] | str = ANY,
    *,
    by: str,
    max_invocations: int = 0,
    id: str | None = None,
) -> Catch:
    """An exception handler: failures named ``exception`` go to the handler served as ``by``.

    Those of subclasses of an exception class are taken too. ``max_invocations`` of 0 is without
    limit.
    """
    name = exception if isinstance(exception, str) else exception.wire_name
    return Catch(
        id=id or _new_id("catch"), exception=name, handler=by, max_invocations=max_invocations
    )


def clean_up(message: TaskMessage[Any], *, id: str | None = None) -> CleanUp:
    """A clean-up: ``message`` is sent when a task that has begun is killed or fails."""
    return CleanUp(id=id or _new_id("cleanup"), sending=sending(message))


def sending(message: type[Message] | Message, *, priority: int | None = None) -> Sending:
    """The message as central sends it.

    Raises:
        ConfigError: It is neither a goal, a command, an inform nor a broadcast.
    """
    kind = message if isinstance(message, type) else type(message)
    if not issubclass(kind, SENDABLE):
        raise ConfigError("listener", kind.__name__, "a goal, a command, an inform or a broadcast")
    traits = traits_of(kind)
    return Sending(
        name=kind.wire_name,
        task_class=_class_of(kind),
        revision=kind.revision,
        data={} if isinstance(message, type) else message.model_dump(mode="json"),
        priority=traits.priority if priority is None else priority,
        traits=traits,
    )


class AttachmentHandle:
    """What was attached to a task or to a message, until `remove` or the end of the block."""

    def __init__(self, what: Attachment, remove: Callable[[str], Awaitable[bool]]) -> None:
        self.what = what
        self._remove = remove

    @property
    def id(self) -> str:
        """The id of the attachment."""
        return self.what.id

    async def remove(self) -> bool:
        """Take it away; gives whether it was still there."""
        return await self._remove(self.id)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.remove()


def _class_of(kind: type[Message]) -> Literal["goal", "command", "inform", "broadcast"]:
    if issubclass(kind, TaskMessage):
        return "goal" if issubclass(kind, Goal) else "command"
    return "inform" if issubclass(kind, Inform) else "broadcast"


def _condition(condition: str) -> TapCondition:
    try:
        return TapCondition(condition)
    except ValueError as error:
        near = near_matches(condition, list(TapCondition))
        hint = f" (did you mean {', '.join(near)}?)" if near else ""
        expected = f"one of {', '.join(sorted(TapCondition))}{hint}"
        raise ConfigError("condition", condition, expected) from error


def _new_id(kind: str) -> str:
    return f"{kind}-{uuid.uuid4().hex[:16]}"
