"""A module: one process's place on the bus."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Sequence
from itertools import groupby
from typing import Any, TypeVar, Unpack

from tca_bus._contexts import ModuleContexts
from tca_bus._errors import TimedOutError
from tca_bus._handle import TaskHandle
from tca_bus._holding import Holding
from tca_bus._keys import Keys
from tca_bus._lease import Acquisition
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
    TcaException,
)
from tca_bus._multi import Answers
from tca_bus._orders import HasPoints
from tca_bus._parts import StatusLookup
from tca_bus._plain import PlainMessages
from tca_bus._presence import PresenceChange, PresentModule
from tca_bus._protocol import Constraint, SubmitTask, TaskStatus
from tca_bus._resource_messages import DeclareResource, HoldKind
from tca_bus._sending import SendOptions
from tca_bus._shared import SharedVariables
from tca_bus._state_server import Lookup
from tca_bus._steering import Steering
from tca_bus._straight_taps import StraightTaps
from tca_bus._streams import Streams
from tca_bus._subscription import Subscription
from tca_bus._task_context import TaskContext
from tca_bus._tasks import TaskSender, new_task_id
from tca_bus._types import answer_adapter
from tca_bus._waiting import ReadyTogether
from tca_bus._wire import Payload, build, decode_answer, encode_message, encode_messages

R = TypeVar("R")
M = TypeVar("M", bound=Message)
HandlerT = TypeVar("HandlerT", bound=Callable[..., Awaitable[Any]])


class Module(PlainMessages, Steering, SharedVariables, ReadyTogether, Holding):
    """One process's place on the bus: an async context manager, entered once.

    It owns one Zenoh session, one TaskGroup and one liveliness token. ``name`` is how others
    find it, ``incarnation`` is new with each start. A ``sole`` one does not share its name: a
    second is refused while the first is there. Enter and leave it in the same task.

    ``provides`` and ``requires`` name resources, words that modules agree on, such as ``map``;
    every module provides one of its own name. With ``hold`` nothing is delivered to its handlers
    before `ready` or `wait_until_ready`: its token names none, so a task waits or finds nobody,
    and a query to it by name is refused as busy.

    Two modules of one name may be there at once: both are seen, the newer one is asked, and both
    warn once.

    Raises:
        ConfigError: The name, or that of a resource, cannot be a part of a key, or the keys for it
            cannot be used.
        BusGoneError: On entering, no router answered within ``options.connect_timeout``.
        RefusedError: On entering, it is ``sole`` and another has its name; or the router does not
            let it in, or not under this name; or the policy does not let it handle a message that
            it has a handler for. Out of a background task when that turns out later.
        ClosedError: From any method that needs the bus, before entering and after leaving.
    """

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
        return decode_answer(answer, answer_adapter(kind), kind.wire_name, revision=kind.revision)  # type: ignore[no-any-return]

    def query_all(
        self, message: MultiQuery[R], *, most: int | None = None, timeout: float = 10.0
    ) -> Answers[R]:
        """Ask all modules that handle the message; the answers come fastest first.

        Ends after ``most`` answers, after ``timeout`` wall seconds, or when all have answered or
        failed. One that fails does not keep the others from answering; the object says how many
        were asked, who answered, who failed and with what, and who is missing.

        Raises:
            ConfigError: ``most`` is below 1.
        """
        return Answers(lambda: self._parts.caller, message, most=most, timeout=timeout)

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

    async def expand(self, goal: Goal[R], **options: Unpack[SendOptions]) -> TaskHandle[R]:
        """Make a goal node at the root of the task tree.

        Returns once central has acknowledged it; `SendOptions` has the options.

        Raises:
            NoHandlerError: No module handles it, or there is no central.
            InvalidMessageError: The data do not fit.
            RefusedError: Another task has the id.
            TimedOutError: No acknowledgement within ``timeout`` wall seconds.
            BusGoneError: The router was away for the rest of that time.
        """
        return await self.submit(goal, **options)

    async def execute(self, command: Command[R], **options: Unpack[SendOptions]) -> TaskHandle[R]:
        """Make a command node at the root of the task tree; see `expand`."""
        return await self.submit(command, **options)

    async def submit(
        self,
        message: TaskMessage[R],
        *,
        inside: TaskContext | None = None,
        **options: Unpack[SendOptions],
    ) -> TaskHandle[R]:
        """Make a goal or command node, at the root or below the node of ``inside``."""
        kind = type(message)
        priority = options.get("priority")
        task = build(
            SubmitTask,
            id=options.get("id") or new_task_id(self.name),
            name=kind.wire_name,
            task_class="goal" if isinstance(message, Goal) else "command",
            message_revision=kind.revision,
            data=message.model_dump(mode="json"),
            sender=self.name,
            parent=inside.id if inside else None,
            constraints=int(options.get("constraints", Constraint.SEQ_ACH)),
            priority=kind.priority if priority is None else priority,
            on_module_lost=options.get("on_module_lost", kind.on_module_lost),
            on_unhandled=options.get("on_unhandled", kind.on_unhandled),
            wait_for_handler=options.get("wait_for_handler", 0.0),
            within=options.get("within"),
            grace=kind.grace,
            orders=tuple(options.get("orders", ())),
            attachments=tuple(options.get("attach", ())),
            is_new=not options.get("id"),
        )
        noted = inside.saw_failure if inside else None
        timeout = options.get("timeout", 10.0)
        return await self._parts.sender.submit(
            task, answer_adapter(kind), timeout=timeout, on_failure=noted
        )

    def answer(self, task: str | HasPoints, result: Any = None) -> None:
        """End a task whose handler in this module postponed its answer.

        Raises:
            TaskError: ``not_postponed``, it waits for no answer here.
        """
        self._parts.worker.answer(task if isinstance(task, str) else task.id_of(), result)

    def answer_failure(self, task: str | HasPoints, error: Exception) -> None:
        """Let a postponed task fail as if its handler had raised ``error``; see `answer`."""
        self._parts.worker.answer(task if isinstance(task, str) else task.id_of(), error)

    async def declare(self, thing: str, *, capacity: int = 1, pending: int | None = None) -> None:
        """Say how many may hold a thing at once, and how many may wait for it.

        What is declared last holds, and is kept by central for good. See `acquire`.

        Raises:
            InvalidMessageError: A value is of no use.
            NoHandlerError: There is no central.
        """
        facts = build(DeclareResource, name=thing, capacity=capacity, pending=pending)
        await self._parts.sender.ask_central(facts, timeout=10.0)

    def hold(
        self,
        kind: HoldKind,
        names: tuple[str, ...],
        *,
        priority: int,
        timeout: float | None,
        inside: TaskContext | None = None,
    ) -> Acquisition:
        """Take resources, for the module or for the task of ``inside``; see `acquire`."""
        return self._parts.leases.acquisition(
            kind,
            names,
            priority=priority,
            timeout=timeout,
            task=inside.id if inside else None,
            attempt=inside.attempt if inside else 0,
        )

    def _hold(
        self, kind: HoldKind, names: tuple[str, ...], *, priority: int, timeout: float | None
    ) -> Acquisition:
        return self.hold(kind, names, priority=priority, timeout=timeout)

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

    @property
    def outages(self) -> int:
        """How often the router was lost so far; what was published meanwhile was not seen."""
        return self._parts.core.session.outages

    def publish_status(self, status: TaskStatus) -> None:
        """Publish a task's state where its sender and late viewers find it; central does."""
        self._streams.publish_status(status)

    def serve_statuses(self, lookup: StatusLookup) -> None:
        """Answer Zenoh gets on the keys of task states; central does.

        ``lookup(sender, id)`` gives the states to answer with; either may be ``*``.
        """
        self._parts.serve_statuses(lookup)

    @property
    def keys(self) -> Keys:
        """The keys of the realm."""
        return self._parts.core.keys

    def publish_state(self, key: str, payload: Payload) -> None:
        """Publish a state on a key of its own; central does."""
        self._parts.topics.send(key, payload)

    def serve_states(self, key: str, lookup: Lookup) -> None:
        """Answer Zenoh gets on ``key`` with the states that ``lookup`` gives; central does."""
        self._parts.serve_states(key, lookup)

    def on_return(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Call ``listener`` when the router is back; gives a function that ends it."""
        return self._parts.on_return(listener)

    @property
    def _streams(self) -> Streams:
        parts = self._parts
        return Streams(parts.core, parts.topics)

    @property
    def _straight(self) -> StraightTaps:
        return StraightTaps(self, self._parts)

    @property
    def _tasks(self) -> TaskSender:
        return self._parts.sender

    def _contexts(self) -> ModuleContexts:
        return ModuleContexts(self)
