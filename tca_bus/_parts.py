"""The parts of an open module, joined."""

from __future__ import annotations

import logging
import os
import socket
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import zenoh
from zenoh.handlers import Callback

from tca_bus._bridge import Mailbox
from tca_bus._caller import Caller
from tca_bus._clock import Clock, WallClock
from tca_bus._context import Context, TaskContext
from tca_bus._core import Core
from tca_bus._handlers import ONE_WAY, Handler, Handlers
from tca_bus._heartbeat import beat
from tca_bus._keys import parse_task
from tca_bus._presence import PresentModule
from tca_bus._protocol import Describe, HandleTask, ModuleCard, TaskStatus
from tca_bus._serving import MOST_WAITING, ContextFactory, QueryServer
from tca_bus._session import SETTLE_TIMEOUT
from tca_bus._sim_time import SimTimeLink
from tca_bus._subscription import Subscription
from tca_bus._tasks import STATUS_ENCODING, TaskSender
from tca_bus._topics import Arrival, Topics
from tca_bus._work import TaskWorker

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
    context: ContextFactory
    task_context: Callable[[HandleTask], TaskContext]
    started: float

    def __post_init__(self) -> None:
        self.topics = Topics(self.core, self.context)
        self.caller = Caller(self.core)
        self.server = QueryServer(self.core, self.handlers, self.context)
        self.sender = TaskSender(self.core, self.caller, self.topics)
        self.worker = TaskWorker(self.core, self.handlers, self.sender, self.task_context)
        self.sim_time = SimTimeLink(self.core, self.topics)
        self._token: zenoh.LivelinessToken | None = None
        self._announced = ""

    @property
    def me(self) -> PresentModule:
        """The module as its token names it."""
        return PresentModule(
            self.core.name,
            self.core.incarnation,
            socket.gethostname(),
            os.getpid(),
            self.handlers.provided(),
        )

    async def begin(self) -> Clock:
        """Declare everything, the liveliness token last: others act on it."""
        self.handlers.add(Describe, self._describe, built_in=True)
        self.worker.begin()
        self.server.begin()
        self.caller.begin()
        self.sender.begin()
        for handler in self.handlers:
            self.attend(handler)
        clock = self._begin_clock()
        await self.core.presence.begin(SETTLE_TIMEOUT)
        self.core.spawn(beat(self.core, self.topics), name=f"{self.core.name}.heartbeat")
        self.announce()
        return clock

    def attend(self, handler: Handler) -> None:
        """Begin to run the handler of a one-way message; others are found when asked for."""
        kind = handler.message_type
        if kind.message_class not in ONE_WAY:
            return
        queue = Subscription[Arrival[Any]](kind.wire_name, _no_source, size=HANDLER_QUEUE)
        self.topics.listen_to(kind, queue.push)
        self.core.tally.counters[f"handler of {kind.wire_name}"] = lambda: queue.dropped
        name = f"{self.core.name}.handler.{kind.wire_name}"
        self.core.spawn(self.topics.handle(handler, queue), name=name)

    def announce(self) -> None:
        """Declare the liveliness token, in place of the one before."""
        key = self.core.keys.presence(self.me)
        if key == self._announced:
            return
        old, self._announced = self._token, key
        self._token = self.core.session.zenoh.liveliness().declare_token(key)
        self.core.presence.add(key)
        if old is not None:
            old.undeclare()

    def end(self) -> None:
        """Stop what is not a task."""
        self.core.presence.end()
        self.caller.end()

    def transport_changed(self, is_up: bool) -> None:
        """The router was lost or is back."""
        self.core.presence.transport_changed(is_up)
        if is_up:
            self.sender.ask_again()

    def serve_statuses(self, lookup: StatusLookup) -> None:
        """Answer Zenoh gets of task states."""
        box = Mailbox[zenoh.Query](
            lambda query: self._reply_statuses(query, lookup),
            size=MOST_WAITING,
            refuse=lambda query: query.drop(),
        )
        self.core.tally.counters["task states asked for"] = lambda: box.dropped
        self.core.session.zenoh.declare_queryable(self.core.keys.all_tasks(), Callback(box.post))

    def _reply_statuses(self, query: zenoh.Query, lookup: StatusLookup) -> None:
        with query:
            for status in lookup(*parse_task(str(query.key_expr))):
                key = zenoh.KeyExpr(self.core.keys.task(status.sender, status.id))
                if query.key_expr.intersects(key):
                    query.reply(key, status.model_dump_json(), encoding=STATUS_ENCODING)

    async def _describe(self, _question: Describe, _context: Context) -> ModuleCard:
        me = self.me
        return ModuleCard(
            name=me.name,
            incarnation=me.incarnation,
            pid=me.pid,
            host=me.host,
            version=version(DISTRIBUTION),
            started=self.started,
            provides=[handler.card() for handler in self.handlers if handler.is_provided],
            dropped=self.core.tally.dropped(),
            invalid=self.core.tally.invalid + self.core.presence.invalid,
            handling=self.worker.handling(),
        )

    def _begin_clock(self) -> Clock:
        if self.clock_kind == "wall":
            return WallClock()
        self.sim_time.begin()
        return self.sim_time.clock


async def _no_source(_: Subscription[Any]) -> Callable[[], None]:
    """Open a subscription that is pushed to by hand."""
    return lambda: None
