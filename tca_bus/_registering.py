"""What a module serves: its handlers and the resources that they share."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any, TypeVar

from tca_bus._lifecycle import Lifecycle
from tca_bus._messages import Message, TcaException

HandlerT = TypeVar("HandlerT", bound=Callable[..., Awaitable[Any]])


class Registering(Lifecycle):
    """Registers handlers, before the module is open or while it is."""

    def resource(self, name: str, *, capacity: int = 1, pending: int | None = None) -> str:
        """Make a resource that handlers share; gives its name, for ``handler(resource=...)``.

        Of the goals and commands of all handlers in it ``capacity`` are handled at a time, and
        at most ``pending`` wait for it: the oldest of the lowest priority fails with
        ``pending_limit``. The resource with the module's own name bounds all its handlers.
        Made before the handlers that go into it.

        Raises:
            ConfigError: The module has one of the name, or a value is of no use.
        """
        return self._handlers.resources.add(name, capacity=capacity, pending=pending).name

    def handler(
        self,
        message_type: type[Message],
        *,
        capacity: int | None = None,
        resource: str | None = None,
        pending: int | None = None,
    ) -> Callable[[HandlerT], HandlerT]:
        """Register the decorated async function as the handler of a message type.

        It is called with the message and a `Context` (a `TaskContext` for goals and commands).
        Queries are handled concurrently, ``capacity`` at a time if one is given; informs and
        broadcasts one at a time, in order of arrival; goals and commands ``capacity`` at a time,
        one by default. Modules that handle one query are a pool: each query goes to one of them,
        and where all are at their capacity the first that has a place takes the next.

        In a ``resource`` all its handlers together have as many at a time as it lets them, queries
        and informs too, but for queries that the module asks itself. At most ``pending`` goals or
        commands wait: the oldest of the lowest priority fails with ``pending_limit``.

        Raises:
            ConfigError: The type has a handler already, the function is not async, there is no
                such resource, or a value is of no use.
        """

        def register(function: HandlerT) -> HandlerT:
            self.serve(
                message_type, function, capacity=capacity, resource=resource, pending=pending
            )
            return function

        return register

    def serve(
        self,
        message_type: type[Message],
        function: Callable[..., Awaitable[Any]],
        *,
        capacity: int | None = None,
        resource: str | None = None,
        pending: int | None = None,
    ) -> None:
        """Register ``function`` as the handler of a message type; see `handler`.

        Raises:
            RefusedError: The policy does not let this module; before it is open, entering it
                raises this.
        """
        if self._open is not None:
            self._open.check_serving(message_type, message_type.wire_name)
        handler = self._handlers.add(
            message_type, function, capacity=capacity, resource=resource, pending=pending
        )
        if self._open is not None:
            self._open.attend(handler)
            self._open.announce()

    def exception_handler(
        self, exception: type[TcaException], *, name: str, capacity: int = 1
    ) -> Callable[[HandlerT], HandlerT]:
        """Register the decorated async function as an exception handler served as ``name``.

        It is called with the exception and an `ExceptionContext`, for the failures to which it is
        attached with ``catch(exception, by=name)``. For `TcaException` itself, which stands for
        all, it is called without the failure's data; the context has them.

        Raises:
            ConfigError: The name is taken, or the function is not async.
        """

        def register(function: HandlerT) -> HandlerT:
            if self._open is not None:
                self._open.check_serving(exception, name)
            self._handlers.add(exception, function, capacity=capacity, name=name)
            if self._open is not None:
                self._open.announce()
            return function

        return register
