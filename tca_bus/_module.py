"""A module: one process's place on the bus."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from itertools import groupby
from typing import Any, TypeVar

from tca_bus._context import Context, TaskContext
from tca_bus._errors import TimedOutError
from tca_bus._handle import TaskHandle
from tca_bus._messages import (
    Broadcast,
    Command,
    Goal,
    Inform,
    Message,
    MessageClass,
    MultiQuery,
    Query,
    TaskMessage,
)
from tca_bus._multi import ask_all
from tca_bus._parts import StatusLookup
from tca_bus._plain import PlainMessages
from tca_bus._presence import PresenceChange, PresentModule
from tca_bus._protocol import Constraint, HandleTask, SubmitTask, TaskStatus
from tca_bus._streams import Streams
from tca_bus._subscription import Subscription
from tca_bus._tasks import new_task_id
from tca_bus._types import answer_adapter
from tca_bus._wire import build, decode_answer, encode_message, encode_messages

R = TypeVar("R")
M = TypeVar("M", bound=Message)
HandlerT = TypeVar("HandlerT", bound=Callable[..., Awaitable[Any]])


class Module(PlainMessages):
    """One process's place on the bus: an async context manager, entered once.

    It owns one Zenoh session, one TaskGroup and one liveliness token. ``name`` is how others
    find it, ``incarnation`` is new with each start. Enter and leave it in the same task.

    Raises:
        ConfigError: The name cannot be a part of a key.
        BusGoneError: On entering, no router answered within ``options.connect_timeout``.
        ClosedError: From any method that needs the bus, before entering and after leaving.
    """

    def handler(
        self, message_type: type[Message], *, capacity: int = 1
    ) -> Callable[[HandlerT], HandlerT]:
        """Register the decorated async function as the handler of a message type.

        It is called with the message and a `Context` (a `TaskContext` for goals and commands).
        Queries are handled concurrently; informs and broadcasts one at a time, in order of
        arrival; goals and commands ``capacity`` at a time.

        Raises:
            ConfigError: The type has a handler already, or the function is not async.
        """

        def register(function: HandlerT) -> HandlerT:
            self.serve(message_type, function, capacity=capacity)
            return function

        return register

    def serve(
        self,
        message_type: type[Message],
        function: Callable[..., Awaitable[Any]],
        *,
        capacity: int = 1,
    ) -> None:
        """Register ``function`` as the handler of a message type; see `handler`."""
        handler = self._handlers.add(message_type, function, capacity=capacity)
        if self._open is not None:
            self._open.attend(handler)
            self._open.announce()

    async def query(
        self, message: Query[R], *, to: str | PresentModule | None = None, timeout: float = 10.0
    ) -> R:
        """Ask the module that handles the message, or module ``to``; gives its answer.

        Sent again by itself over a restart of the router; the callee handles it once.

        Raises:
            NoHandlerError: No module here handles it.
            InvalidMessageError: It, or the answer, does not fit; a matter of versions.
            HandlerFailedError: The handler raised; ``failure`` says what.
            RefusedError: The callee will not; a `BusyError` when it has too much to do.
            PeerLostError: The callee died before it answered.
            TimedOutError: No answer within ``timeout`` wall seconds.
            BusGoneError: The router was away for the rest of that time.
        """
        kind = type(message)
        answer = await self._parts.caller.call(
            kind.wire_name, encode_message(message), to=to, timeout=timeout
        )
        return decode_answer(answer, answer_adapter(kind), kind.wire_name)  # type: ignore[no-any-return]

    def query_all(self, message: MultiQuery[R], *, timeout: float = 10.0) -> AsyncIterator[R]:
        """Ask all modules that handle the message; the answers come fastest first.

        One that fails does not keep the others from answering.

        Raises:
            NoHandlerError: No module here handles it.
            ExceptionGroup: After all answers: what those who gave none failed with.
        """
        return ask_all(self._parts.caller, message, timeout)

    async def inform(self, message: Inform) -> None:
        """Tell all modules that handle the message; returns when it is sent.

        Raises:
            NoHandlerError: No module here handles it.
            BusGoneError: The router is away and did not come back within ``connect_timeout``.
        """
        await self._inform(message.wire_name, encode_message(message))

    async def inform_many(self, messages: Sequence[Inform]) -> None:
        """Tell many things at once; they arrive in order, each as if it had been sent alone.

        Neighbours of one type travel together, which costs a fraction of sending each. Of those
        that travel together a receiver takes all, or none if one does not fit.

        Raises as `inform` does; what came before the message that nobody handles was sent.
        """
        for name, together in groupby(messages, key=lambda message: message.wire_name):
            await self._inform(name, *encode_messages(list(together)))

    async def broadcast_many(self, messages: Sequence[Broadcast]) -> None:
        """Tell many things at once to everybody who listens; see `inform_many`."""
        for name, together in groupby(messages, key=lambda message: message.wire_name):
            for payload in encode_messages(list(together)):
                self._parts.topics.publish(MessageClass.BROADCAST, name, payload)

    async def broadcast(self, message: Broadcast) -> None:
        """Tell everybody who listens; lost, and counted, while the router is away."""
        payload = encode_message(message)
        self._parts.topics.publish(MessageClass.BROADCAST, message.wire_name, payload)

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
        """Make a goal node at the root of the task tree.

        Returns once central has acknowledged it. ``id`` makes it idempotent: a second call with
        it, even from a later process, gives the same node and its recorded outcome.
        ``wait_for_handler`` is how many seconds central waits for a module that handles it.

        Raises:
            NoHandlerError: No module handles it, or there is no central.
            InvalidMessageError: The data do not fit.
            RefusedError: Another task has the id.
            TimedOutError: No acknowledgement within ``timeout`` wall seconds.
            BusGoneError: The router was away for the rest of that time.
        """
        return await self.submit(
            goal,
            id=id,
            constraints=constraints,
            priority=priority,
            wait_for_handler=wait_for_handler,
            timeout=timeout,
        )

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
        """Make a command node at the root of the task tree; see `expand`."""
        return await self.submit(
            command,
            id=id,
            constraints=constraints,
            priority=priority,
            wait_for_handler=wait_for_handler,
            timeout=timeout,
        )

    async def submit(
        self,
        message: TaskMessage[R],
        *,
        id: str | None = None,
        constraints: Constraint = Constraint.SEQ_ACH,
        priority: int = 0,
        wait_for_handler: float = 0.0,
        timeout: float = 10.0,
        inside: TaskContext | None = None,
    ) -> TaskHandle[R]:
        """Make a goal or command node, at the root or below the node of ``inside``."""
        kind = type(message)
        task = build(
            SubmitTask,
            id=id or new_task_id(self.name),
            name=kind.wire_name,
            task_class="goal" if isinstance(message, Goal) else "command",
            message_revision=kind.revision,
            data=message.model_dump(mode="json"),
            sender=self.name,
            parent=inside.id if inside else None,
            constraints=int(constraints),
            priority=priority,
            on_module_lost=kind.on_module_lost,
            wait_for_handler=wait_for_handler,
        )
        noted = inside.saw_failure if inside else None
        return await self._parts.sender.submit(
            task, answer_adapter(kind), timeout=timeout, on_failure=noted
        )

    async def kill(self, task_id: str, *, reason: str, only_below: bool = False) -> TaskStatus:
        """Ask central to kill a task and all below it, or only what is below it.

        Gives the state it is in then; its handlers may take a while to stop.
        """
        return await self._parts.sender.kill(task_id, reason=reason, only_below=only_below)

    def subscribe(self, message_type: type[M], *, size: int = 256) -> Subscription[M]:
        """Listen to a broadcast or inform type, whoever sends it."""
        return self._streams.messages(message_type, size=size)

    def watch_modules(self) -> Subscription[PresenceChange]:
        """Stream the comings and losses of modules, beginning with those that are there."""
        return self._streams.modules()

    def watch_statuses(self, *, sender: str = "*", size: int = 1024) -> Subscription[TaskStatus]:
        """Stream task states as central publishes them, of one sender or of all."""
        return self._streams.statuses(sender, size=size)

    def modules(self) -> list[PresentModule]:
        """The modules on the bus, this one among them, by name."""
        return self._parts.core.presence.table.modules()

    async def wait_for(self, *messages: type[Message] | str, timeout: float) -> None:
        """Wait until a provider of each message is present.

        Raises:
            TimedOutError: Not within ``timeout`` wall seconds; it names what is missing.
        """
        names = [name if isinstance(name, str) else name.wire_name for name in messages]
        presence = self._parts.core.presence

        def missing() -> list[str]:
            return [name for name in names if not presence.table.has_provider(name)]

        try:
            async with asyncio.timeout(timeout):
                await presence.until(lambda: not missing())
        except TimeoutError as error:
            what = f"a module that handles {', '.join(map(repr, missing()))}"
            raise TimedOutError(what, timeout) from error

    async def serve_forever(self) -> None:
        """Serve until cancelled."""
        await asyncio.get_running_loop().create_future()

    async def connected(self) -> None:
        """Wait until the router is reachable."""
        await self._parts.core.session.connected()

    @property
    def is_connected(self) -> bool:
        """Whether the router is reachable now."""
        return self._parts.core.session.is_up

    def publish_status(self, status: TaskStatus) -> None:
        """Publish a task's state where its sender and late viewers find it; central does."""
        self._streams.publish_status(status)

    def serve_statuses(self, lookup: StatusLookup) -> None:
        """Answer Zenoh gets on the keys of task states; central does.

        ``lookup(sender, id)`` gives the states to answer with; either may be ``*``.
        """
        self._parts.serve_statuses(lookup)

    @property
    def _streams(self) -> Streams:
        parts = self._parts
        return Streams(parts.core, parts.topics)

    def _context(self, *, sender: str, id: str) -> Context:
        return Context(self, sender=sender, id=id)

    def _task_context(self, task: HandleTask) -> TaskContext:
        return TaskContext(self, sender=task.sender, id=task.id, attempt=task.attempt)
