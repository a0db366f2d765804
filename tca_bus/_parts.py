"""The parts of an open module, joined."""

from __future__ import annotations

import logging
import os
import socket
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from importlib.metadata import version
from typing import Any

import zenoh

from tca_bus._caller import Caller
from tca_bus._clock import Clock, WallClock
from tca_bus._context import Context
from tca_bus._core import Core
from tca_bus._handlers import ONE_WAY, Handler, Handlers
from tca_bus._heartbeat import beat
from tca_bus._keys import parse_task
from tca_bus._leases import Leases
from tca_bus._loop_watch import watch_loop
from tca_bus._messages import Message, MessageClass
from tca_bus._policy_link import fetch_policy
from tca_bus._presence import PresentModule, Stage
from tca_bus._protocol import Describe, ModuleCard, TaskStatus
from tca_bus._readiness import Readiness
from tca_bus._rights import Right
from tca_bus._serving import QueryServer
from tca_bus._session import SETTLE_TIMEOUT
from tca_bus._sim_time import SimTimeLink
from tca_bus._sole import be_only, yield_to_older
from tca_bus._state_server import Lookup, StateServer
from tca_bus._subscription import Subscription
from tca_bus._tapping import TellTap
from tca_bus._tasks import STATUS_ENCODING, TaskSender
from tca_bus._topics import Arrival, Topics
from tca_bus._wire import Payload
from tca_bus._work import Contexts, TaskWorker

logger = logging.getLogger(__name__)

HANDLER_QUEUE = 1024
"""Informs or broadcasts that wait for one handler; when full the oldest is dropped."""

DISTRIBUTION = "rogue-on-xavier"

StatusLookup = Callable[[str, str], Sequence[TaskStatus]]


@dataclass
class Parts:
    """What a module consists of while it is open."""

    core: Core
    handlers: Handlers
    clock_kind: str
    contexts: Contexts
    started: float
    readiness: Readiness
    sole: bool = False

    def __post_init__(self) -> None:
        self.topics = Topics(self.core, self.contexts.plain)
        self.caller = Caller(self.core)
        self.server = QueryServer(self.core, self.handlers, self.contexts.plain)
        self.sender = TaskSender(self.core, self.caller, self.topics)
        self.leases = Leases(self.core, self.sender, self.topics)
        self.sender.holding = self.leases.held_here
        self.worker = TaskWorker(self.core, self.handlers, self.sender, self.contexts)
        self.sim_time = SimTimeLink(self.core, self.topics)
        self._token: zenoh.LivelinessToken | None = None
        self._tokens = 0
        self._announced: PresentModule | None = None
        self._on_return: list[Callable[[], None]] = []

    @property
    def me(self) -> PresentModule:
        """The module as its token names it."""
        return PresentModule(
            self.core.name,
            self.core.incarnation,
            socket.gethostname(),
            os.getpid(),
            self.handlers.provided(),
            self.readiness.resources,
            self.readiness.requires,
            self.readiness.stage,
            self._tokens,
            self.core.tapping.words(),
        )

    async def begin(self) -> Clock:
        """Declare everything, the liveliness token last: others act on it.

        Raises:
            RefusedError: The module may not join under its name, or not handle a message.
        """
        await self.learn_policy()
        self.handlers.add(Describe, self._describe, built_in=True)
        self.handlers.add(TellTap, self.core.tapping.told, built_in=True)
        self.core.tapping.begin(self.core, self.caller.call)
        self.worker.begin()
        self.caller.begin()
        self.server.begin()
        self.sender.begin()
        self.handlers.is_held = self.readiness.stage == Stage.HELD
        for handler in self.handlers:
            self.attend(handler)
        clock = self._begin_clock()
        await self.core.presence.begin(SETTLE_TIMEOUT)
        if self.sole:
            realm = self.core.keys.realm
            await be_only(self.core.presence, self.me, realm)
            watch = yield_to_older(self.core.presence, self.me, realm)
            self.core.spawn(watch, name=f"{self.core.name}.sole")
        self.core.spawn(beat(self.core, self.topics), name=f"{self.core.name}.heartbeat")
        self.core.spawn(watch_loop(self.core.name), name=f"{self.core.name}.loop_watch")
        self.announce()
        return clock

    def attend(self, handler: Handler) -> None:
        """Begin to run the handler of a one-way message; others are found when asked for."""
        kind = handler.message_type
        self.check_serving(kind, handler.name)
        if kind.message_class not in ONE_WAY or self.handlers.is_held:
            return
        queue = Subscription[Arrival[Any]](kind.wire_name, _no_source, size=HANDLER_QUEUE)
        self.topics.listen_to(kind, partial(self._queue, queue))
        self.core.tally.counters[f"handler of {kind.wire_name}"] = lambda: queue.dropped
        name = f"{self.core.name}.handler.{kind.wire_name}"
        self.core.spawn(self.topics.handle(handler, self.handlers, queue), name=name)

    def _queue(self, queue: Subscription[Arrival[Any]], arrival: Arrival[Any]) -> None:
        lost = queue.dropped
        queue.push(arrival)
        if queue.dropped > lost:
            text = f"handler of {queue.name} does not keep up: {queue.waiting} wait, the oldest"
            self.core.tally.complain(f"queue of {queue.name}", f"{text} is dropped")

    def check_serving(self, kind: type[Message], name: str) -> None:
        """Refuse to handle, under a name, a message that this module may not handle.

        Raises:
            RefusedError: It may not.
        """
        if kind.message_class != MessageClass.BROADCAST:
            self.core.permissions.check(self.core.name, Right.SERVE, name)

    async def learn_policy(self) -> None:
        """Ask the router who may do what; one that lets everybody in has no policy.

        Raises:
            RefusedError: The module may not join under its name.
        """
        permissions, session = self.core.permissions, self.core.session
        if session.credentials.is_given and not permissions.is_fixed:
            permissions.policy = await fetch_policy(
                session, self.core.keys, self.core.name, default=permissions.policy
            )

    def announce(self) -> None:
        """Declare the liveliness token, in place of the one before."""
        if self.me == self._announced:
            return
        self._tokens += 1
        self._announced = self.me
        key = self.core.keys.presence(self.me)
        old = self._token
        self._token = self.core.session.declare_token(key)
        self.core.presence.add(key)
        if old is not None:
            self.core.session.undeclare(old)

    def enter_stage(self, stage: Stage) -> None:
        """Say how ready the module is; from `Stage.READY` on everything is delivered to it."""
        self.readiness.stage = stage
        if stage == Stage.READY and self.handlers.is_held:
            self.handlers.is_held = False
            for handler in self.handlers:
                self.attend(handler)
        self.announce()

    def end(self) -> None:
        """Stop what is not a task."""
        self.core.presence.end()
        self.caller.end()

    def transport_changed(self, is_up: bool) -> None:
        """The router was lost or is back."""
        self.core.presence.transport_changed(is_up)
        if is_up:
            self.sender.ask_again()
            self.core.spawn(self.learn_policy(), name=f"{self.core.name}.policy")
            self.leases.ask_again()
            for listener in list(self._on_return):
                listener()

    def on_return(self, listener: Callable[[], None]) -> Callable[[], None]:
        """Call ``listener`` when the router is back; gives a function that ends it."""
        self._on_return.append(listener)
        return lambda: self._on_return.remove(listener)

    def serve_states(self, key: str, lookup: Lookup) -> None:
        """Answer Zenoh gets of published states."""
        StateServer(self.core, key, lookup).begin()

    def serve_statuses(self, lookup: StatusLookup) -> None:
        """Answer Zenoh gets of task states."""

        def states(key: str) -> list[tuple[str, Payload]]:
            return [
                (
                    self.core.keys.task(status.sender, status.id),
                    Payload(status.model_dump_json().encode(), STATUS_ENCODING),
                )
                for status in lookup(*parse_task(key))
            ]

        self.serve_states(self.core.keys.all_tasks(), states)

    async def _describe(self, _question: Describe, _context: Context) -> ModuleCard:
        me = self.me
        return ModuleCard(
            name=me.name,
            incarnation=me.incarnation,
            pid=me.pid,
            host=me.host,
            version=_own_version(),
            started=self.started,
            provides=[handler.card() for handler in self.handlers if handler.is_provided],
            resources=self.handlers.resources.cards(),
            dropped=self.core.tally.dropped(),
            invalid=self.core.tally.invalid,
            handling=self.worker.handling(),
        )

    def _begin_clock(self) -> Clock:
        if self.clock_kind == "wall":
            return WallClock()
        self.sim_time.begin()
        return self.sim_time.clock


@cache
def _own_version() -> str:
    return version(DISTRIBUTION)


async def _no_source(_: Subscription[Any]) -> Callable[[], None]:
    """Open a subscription that is pushed to by hand."""
    return lambda: None
