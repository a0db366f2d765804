"""The handlers of a module, by the wire names of their messages."""

from __future__ import annotations

import asyncio
import contextlib
import inspect
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import dataclass
from typing import Any

from tca_bus._errors import ConfigError, RefusedError
from tca_bus._messages import Message, MessageClass
from tca_bus._options import CHUNK_EXPECTED, CHUNK_PATTERN
from tca_bus._protocol import ProvidedMessage
from tca_bus._slots import Resources, check_pending
from tca_bus._traits import traits_of
from tca_bus._types import answer_schema, message_schema, summary

QUERIES = frozenset({MessageClass.QUERY, MessageClass.MULTI_QUERY})
ONE_WAY = frozenset({MessageClass.INFORM, MessageClass.BROADCAST})
TASKS = frozenset({MessageClass.GOAL, MessageClass.COMMAND})
IN_THE_TREE = TASKS | {MessageClass.EXCEPTION, MessageClass.DEMON}
"""The classes whose handlers central calls."""

HandlerFunction = Callable[..., Awaitable[Any]]


@dataclass(frozen=True, slots=True)
class Handler:
    """A function that handles a message type; ``built_in`` ones are not announced.

    ``name`` is that under which it is found: the message's, but for exception handlers, of which
    there may be several for one exception. ``capacity`` is how many it handles at once, None for
    as many as come.
    """

    message_type: type[Message]
    function: HandlerFunction
    capacity: int | None
    built_in: bool
    name: str
    resource: str | None = None
    pending: int | None = None

    @property
    def is_provided(self) -> bool:
        """Whether others find it by its name: listening to broadcasts is no service."""
        return not self.built_in and self.message_type.message_class != MessageClass.BROADCAST

    @property
    def is_query(self) -> bool:
        """Whether it answers queries."""
        kind = self.message_type.message_class
        return kind is MessageClass.QUERY or kind is MessageClass.MULTI_QUERY

    async def call(self, message: Any, context: Any) -> Any:
        """Run the function; a place for it is the caller's to hold.

        Raises:
            RefusedError: It ended as cancelled, though nobody had cancelled it: something that
                it waited for was.
        """
        try:
            return await self.function(message, context)
        except asyncio.CancelledError as error:
            task = asyncio.current_task()
            if task is None or task.cancelling():
                raise
            raise RefusedError(self.name, "its handler was cancelled") from error

    def card(self) -> ProvidedMessage:
        """The handler as others see it."""
        kind = self.message_type
        answered = kind.message_class in QUERIES | TASKS
        return ProvidedMessage(
            name=self.name,
            message_class=kind.message_class.value,
            revision=kind.revision,
            accepts=sorted(kind.accepts),
            summary=summary(kind),
            message_schema=message_schema(kind),
            reply_schema=answer_schema(kind) if answered else None,
            capacity=self.capacity,
            resource=self.resource,
            pending=self.pending,
            traits=traits_of(kind) if kind.message_class in TASKS else None,
        )


class Handlers:
    """The handlers of one module, and the resources that they share."""

    def __init__(self, module: str = "") -> None:
        self._by_name: dict[str, Handler] = {}
        self.is_held = False
        """Whether nothing is delivered yet: the module has not said that it is ready."""
        self.resources = Resources(module)

    def add(
        self,
        message_type: type[Message],
        function: HandlerFunction,
        *,
        capacity: int | None = None,
        built_in: bool = False,
        name: str | None = None,
        resource: str | None = None,
        pending: int | None = None,
    ) -> Handler:
        """Register a handler; without ``capacity`` queries are unlimited, all others one at a time.

        Raises:
            ConfigError: There is one for the name, or name, capacity or function are of no use.
        """
        name = name or message_type.wire_name
        if not CHUNK_PATTERN.fullmatch(name):
            raise ConfigError("wire name", name, CHUNK_EXPECTED)
        if name in self._by_name:
            raise ConfigError("handler", name, "a message that has no handler in this module yet")
        capacity = self._capacity(capacity, resource, message_type.message_class)
        check_pending(pending)
        if pending is not None and message_type.message_class not in TASKS:
            raise ConfigError("pending", pending, f"none for {name!r}: it is no goal or command")
        if not inspect.iscoroutinefunction(function):
            raise ConfigError("handler", function, "an async function (message, context)")
        handler = Handler(message_type, function, capacity, built_in, name, resource, pending)
        self._by_name[name] = handler
        return handler

    def _capacity(
        self, capacity: int | None, resource: str | None, kind: MessageClass
    ) -> int | None:
        if capacity is not None and capacity < 1:
            raise ConfigError("capacity", capacity, "at least 1")
        if resource is None:
            return capacity if kind in QUERIES else capacity or 1
        self.resources.check(resource)
        if capacity is not None:
            expected = f"none for a handler in resource {resource!r}, which has one for all"
            raise ConfigError("capacity", capacity, expected)
        return None if kind in QUERIES else self.resources.capacity(resource)

    def place(self, handler: Handler) -> contextlib.AbstractAsyncContextManager[None]:
        """Hold a place in the handler's resources while the block runs."""
        return self.resources.place(handler.name, handler.capacity or 1, handler.resource)

    def get(self, name: str) -> Handler | None:
        """The handler of a message, if there is one."""
        return self._by_name.get(name)

    def __iter__(self) -> Iterator[Handler]:
        return iter(list(self._by_name.values()))

    def provided(self) -> tuple[str, ...]:
        """The names that the module's token announces; none while it is held."""
        if self.is_held:
            return ()
        return tuple(sorted(h.name for h in self if h.is_provided))
