"""A module: one process's place on the bus."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, TypeVar, Unpack

from tca_bus._contexts import ModuleContexts
from tca_bus._handle import TaskHandle
from tca_bus._holding import Holding
from tca_bus._keys import Keys
from tca_bus._lease import Acquisition
from tca_bus._messages import Command, Goal, TaskMessage
from tca_bus._orders import HasPoints
from tca_bus._parts import StatusLookup
from tca_bus._protocol import TaskStatus
from tca_bus._registering import Registering
from tca_bus._resource_messages import DeclareResource, HoldKind
from tca_bus._sending import SendOptions, submission
from tca_bus._shared import SharedVariables
from tca_bus._state_server import Lookup
from tca_bus._steering import Steering
from tca_bus._straight_taps import StraightTaps
from tca_bus._talking import Talking
from tca_bus._task_context import TaskContext
from tca_bus._tasks import TaskSender
from tca_bus._traits import traits_of
from tca_bus._types import answer_adapter
from tca_bus._waiting import ReadyTogether
from tca_bus._wire import Payload, build

R = TypeVar("R")


class Module(Registering, Talking, Steering, SharedVariables, ReadyTogether, Holding):
    """One process's place on the bus: an async context manager, entered once.

    It owns one TaskGroup, one liveliness token and, unless the options share it, one Zenoh
    session. ``name`` is how others find it, ``incarnation`` is new with each start. A ``sole`` one
    does not share its name: a second is refused while the first is there. Enter and leave it in
    the same task.

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
        task = submission(
            kind.wire_name,
            message.model_dump(mode="json"),
            options,
            task_class="goal" if isinstance(message, Goal) else "command",
            revision=kind.revision,
            traits=traits_of(kind),
            sender=self.name,
            parent=inside.id if inside else None,
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
    def _straight(self) -> StraightTaps:
        return StraightTaps(self, self._parts)

    @property
    def _tasks(self) -> TaskSender:
        return self._parts.sender

    def _contexts(self) -> ModuleContexts:
        return ModuleContexts(self)
