"""A module: one process's place on the bus."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Sequence
from types import TracebackType
from typing import Any, Self, TypeVar

from tca_bus._clock import Clock
from tca_bus._handle import TaskHandle
from tca_bus._messages import Broadcast, Command, Goal, Inform, Message, Query
from tca_bus._options import BusOptions
from tca_bus._presence import PresenceChange, PresentModule
from tca_bus._protocol import Constraint, TaskStatus
from tca_bus._subscription import Subscription

R = TypeVar("R")
M = TypeVar("M", bound=Message)
Handler = TypeVar("Handler", bound=Callable[..., Awaitable[Any]])


class Module:
    """One process's place on the bus."""

    incarnation: str
    clock: Clock

    def __init__(self, name: str, *, options: BusOptions | None = None) -> None:
        self.name = name
        self.options = options or BusOptions()

    def handler(
        self, message_type: type[Message], *, capacity: int = 1
    ) -> Callable[[Handler], Handler]:
        """Register the decorated function as the handler of ``message_type``."""
        raise NotImplementedError

    def serve(
        self,
        message_type: type[Message],
        function: Callable[..., Awaitable[Any]],
        *,
        capacity: int = 1,
    ) -> None:
        """Register ``function`` as the handler of ``message_type``."""
        raise NotImplementedError

    async def __aenter__(self) -> Self:
        raise NotImplementedError

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        raise NotImplementedError

    async def query(
        self, message: Query[R], *, to: str | PresentModule | None = None, timeout: float = 10.0
    ) -> R:
        """Ask the module that handles the message (or ``to``) and give its answer."""
        raise NotImplementedError

    async def query_json(
        self, name: str, data: dict[str, Any], *, to: str | None = None, timeout: float = 10.0
    ) -> Any:
        """Query by wire name with plain data, for tools that have no message type."""
        raise NotImplementedError

    async def inform(self, message: Inform) -> None:
        """Tell the modules that handle the message."""
        raise NotImplementedError

    async def inform_json(self, name: str, data: dict[str, Any]) -> None:
        """Inform by wire name with plain data."""
        raise NotImplementedError

    async def broadcast(self, message: Broadcast) -> None:
        """Tell everybody who listens."""
        raise NotImplementedError

    async def broadcast_json(self, name: str, data: dict[str, Any]) -> None:
        """Broadcast by wire name with plain data."""
        raise NotImplementedError

    async def expand(
        self,
        goal: Goal[R],
        *,
        id: str | None = None,
        constraints: Constraint = Constraint.SEQ_ACH,
        priority: int = 0,
        wait_for_handler: float = 0.0,
        timeout: float = 10.0,
    ) -> TaskHandle[R]:
        """Make a goal node at the root; returns once central has acknowledged it."""
        raise NotImplementedError

    async def execute(
        self,
        command: Command[R],
        *,
        id: str | None = None,
        constraints: Constraint = Constraint.SEQ_ACH,
        priority: int = 0,
        wait_for_handler: float = 0.0,
        timeout: float = 10.0,
    ) -> TaskHandle[R]:
        """Make a command node at the root; returns once central has acknowledged it."""
        raise NotImplementedError

    async def submit_json(
        self,
        name: str,
        data: dict[str, Any],
        *,
        task_class: str,
        id: str | None = None,
        priority: int = 0,
        wait_for_handler: float = 0.0,
        timeout: float = 10.0,
    ) -> TaskHandle[Any]:
        """Make a root node by wire name with plain data; ``task_class`` is goal or command."""
        raise NotImplementedError

    async def kill(self, task_id: str, *, reason: str, only_below: bool = False) -> TaskStatus:
        """Ask central to kill a task."""
        raise NotImplementedError

    def subscribe(self, message_type: type[M], *, size: int = 256) -> Subscription[M]:
        """Listen to a broadcast or inform type."""
        raise NotImplementedError

    def modules(self) -> list[PresentModule]:
        """The modules on the bus."""
        raise NotImplementedError

    def watch_modules(self) -> Subscription[PresenceChange]:
        """Stream appearances and losses of modules, beginning with those that are there."""
        raise NotImplementedError

    async def wait_for(self, *messages: type[Message] | str, timeout: float) -> None:
        """Wait until a provider of each message is present."""
        raise NotImplementedError

    async def serve_forever(self) -> None:
        """Serve until cancelled."""
        raise NotImplementedError

    def start(self, coroutine: Coroutine[Any, Any, Any], *, name: str) -> asyncio.Task[Any]:
        """Run a background task in the module's TaskGroup."""
        raise NotImplementedError

    async def connected(self) -> None:
        """Wait until the router is reachable."""
        raise NotImplementedError

    def publish_status(self, status: TaskStatus) -> None:
        """Publish a task's state on ``<realm>/task/<sender>/<id>`` (central does)."""
        raise NotImplementedError

    def serve_statuses(self, lookup: Callable[[str, str], Sequence[TaskStatus]]) -> None:
        """Answer Zenoh gets on ``<realm>/task/**``; ``lookup(sender, id)``, either may be '*'."""
        raise NotImplementedError

    def watch_statuses(self, *, sender: str = "*", size: int = 1024) -> Subscription[TaskStatus]:
        """Stream task states as central publishes them."""
        raise NotImplementedError
