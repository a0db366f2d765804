"""Records what passes on a realm: listens without standing in the way, writes on a thread."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

import zenoh
from zenoh.handlers import Callback

from tca_bus._access import audible
from tca_bus._bridge import Mailbox, attachment_of, payload_of
from tca_bus._errors import TcaError
from tca_bus._heartbeat import Heartbeat
from tca_bus._messages import Message
from tca_bus._module import Module
from tca_bus._presence import PresenceChange, PresentModule
from tca_bus._protocol import Describe, TaskStatus
from tca_bus._recording import Passed, RecordingWriter
from tca_bus._recording_reader import RecordingError
from tca_bus._selection import Selection
from tca_bus._time_messages import AwaitTime, Settle, Settled, SimulatedTime
from tca_bus._uninterrupted import uninterrupted
from tca_bus._wire import Payload

logger = logging.getLogger(__name__)

FLUSH_PERIOD = 1.0
"""Wall seconds after which what passed is in the file: what a kill by force may cost."""

MOST_WAITING = 65_536
"""Messages that wait to be written."""

MOST_BYTES = 256 << 20
"""Bytes of them."""

CARD_TIMEOUT = 2.0
"""Wall seconds in which a module tells the schemas of its messages."""

OWN_TYPES: tuple[type[Message], ...] = (Heartbeat, SimulatedTime, AwaitTime, Settle, Settled)

PRESENCE_ENCODING = "application/json;tca.presence@1"


class Backlog:
    """What waits to be written: bounded; what does not fit is dropped and counted."""

    def __init__(self, *, most: int = MOST_WAITING, most_bytes: int = MOST_BYTES) -> None:
        self._most, self._most_bytes = most, most_bytes
        self._waiting: list[Passed] = []
        self._bytes = 0
        self.dropped = 0

    def push(self, passed: Passed) -> None:
        """Append a message if there is room."""
        size = len(passed.payload.data)
        if len(self._waiting) >= self._most or self._bytes + size > self._most_bytes:
            self.dropped += 1
            return
        self._waiting.append(passed)
        self._bytes += size

    def take(self) -> list[Passed]:
        """Everything that waits, in order."""
        taken, self._waiting, self._bytes = self._waiting, [], 0
        return taken

    @property
    def is_half_full(self) -> bool:
        """Whether it is time to write though the period is not over."""
        return 2 * len(self._waiting) >= self._most or 2 * self._bytes >= self._most_bytes


@dataclass
class Recorder:
    """Writes what passes on the realm of an open module into a binary stream.

    What the module itself sends is left out. ``on_drop`` is called with the number of messages
    lost so far, when it has grown.
    """

    module: Module
    path: Path
    stream: IO[bytes]
    selection: Selection
    on_drop: Callable[[int], None] = lambda _: None
    backlog: Backlog = field(default_factory=Backlog)
    _schemas: dict[str, dict[str, Any]] = field(default_factory=dict)
    _boxes: list[Mailbox[zenoh.Sample]] = field(default_factory=list)
    _bell: asyncio.Event = field(default_factory=asyncio.Event)
    _told: int = 0

    def __post_init__(self) -> None:
        types = {f"{kind.wire_name}@{kind.revision}": kind for kind in OWN_TYPES}
        self._schemas |= {name: kind.model_json_schema() for name, kind in types.items()}
        self._schemas["tca.status@1"] = TaskStatus.model_json_schema()
        realm = self.module.options.realm
        self.writer = RecordingWriter(self.stream, realm, self._schemas)

    @property
    def dropped(self) -> int:
        """How many messages were lost on the way to the file."""
        return self.backlog.dropped + sum(box.dropped for box in self._boxes)

    async def run(self, duration: float | None = None) -> None:
        """Record for so many wall seconds, or until cancelled; the file is complete after it.

        Behind a policy it records what the module may hear.

        Raises:
            RecordingError: The file cannot be written any more.
            RefusedError: The module may hear nothing of what is selected.
        """
        policy = self.module.permissions.policy
        if policy is not None:
            self.selection = self.selection.within(audible(policy, self.module.name))
        await self._learn(self.module.modules())
        with self._listening():
            await self.module.core.session.settle(self.module.core.keys.all_presence())
            try:
                async with asyncio.timeout(duration):
                    while True:
                        await self._pause()
                        await uninterrupted(self._write(self.backlog.take()))
            except TimeoutError:
                logger.debug("recorded for %s s", duration)
            finally:
                await uninterrupted(self._finish())

    async def _pause(self) -> None:
        self._bell.clear()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(FLUSH_PERIOD):
                await self._bell.wait()

    async def _finish(self) -> None:
        await self._write(self.backlog.take())
        await self._on_disk(lambda: self.writer.finish(self.dropped))

    async def _write(self, batch: list[Passed]) -> None:
        def write() -> None:
            for passed in batch:
                self.writer.write(passed)
            self.writer.flush()

        await self._on_disk(write)
        if self.dropped > self._told:
            self._told = self.dropped
            self.on_drop(self.dropped)

    async def _on_disk(self, work: Callable[[], None]) -> None:
        try:
            await asyncio.to_thread(work)
        except OSError as error:
            why = f"it cannot be written any more ({error.strerror or error})"
            raise RecordingError(self.path, why) from error

    @contextlib.contextmanager
    def _listening(self) -> Iterator[None]:
        core = self.module.core
        declared = [self._subscribe(n, e) for n, e in enumerate(self.selection.expressions)]
        for module in self.module.modules():
            self._presence(PresenceChange(module, appeared=True))
        end = core.presence.listen(self._presence)
        try:
            yield
        finally:
            end()
            for subscriber in declared:
                core.session.undeclare(subscriber)

    def _subscribe(self, number: int, expression: str) -> zenoh.Subscriber[None]:
        def take(sample: zenoh.Sample) -> None:
            self._take(sample, number)

        core = self.module.core
        box = Mailbox[zenoh.Sample](take, size=MOST_WAITING)
        self._boxes.append(box)
        key = f"{core.keys.realm}/{expression}"
        return core.session.declare_subscriber(key, Callback(box.post))

    def _take(self, sample: zenoh.Sample, number: int) -> None:
        key = str(sample.key_expr).removeprefix(f"{self.module.options.realm}/")
        # Keys that several expressions match come once for each.
        if key.endswith(f"/{self.module.name}") or self.selection.first(key) != number:
            return
        seen = time.time_ns()
        stamp = sample.timestamp
        published = int(stamp.get_time().timestamp() * 1e9) if stamp else seen
        is_gone = sample.kind == zenoh.SampleKind.DELETE
        self._push(Passed(key, payload_of(sample), attachment_of(sample), published, seen, is_gone))

    def _presence(self, change: PresenceChange) -> None:
        module = change.module
        core = self.module.core
        key = core.keys.presence(module).removeprefix(f"{core.keys.realm}/")
        if module.incarnation == core.incarnation or not self.selection.includes(key):
            return
        now = time.time_ns()
        payload = Payload(_presence_json(change), PRESENCE_ENCODING)
        self._push(Passed(key, payload, None, now, now, is_gone=not change.appeared))
        if change.appeared:
            self.module.start(self._learn([module]), name=f"recorder.describe.{module.name}")

    def _push(self, passed: Passed) -> None:
        self.backlog.push(passed)
        if self.backlog.is_half_full:
            self._bell.set()

    async def _learn(self, modules: list[PresentModule]) -> None:
        """Ask modules for the schemas of the messages that they handle."""
        await asyncio.gather(*(self._learn_from(module) for module in modules))

    async def _learn_from(self, module: PresentModule) -> None:
        try:
            card = await self.module.query(Describe(), to=module, timeout=CARD_TIMEOUT)
        except TcaError as error:
            logger.info("the schemas of module %s are not known: %s", module.name, error)
            return
        for told in card.provides:
            self._schemas[f"{told.name}@{told.revision}"] = told.message_schema


def _presence_json(change: PresenceChange) -> bytes:
    module = change.module
    told = {
        "module": module.name,
        "incarnation": module.incarnation,
        "host": module.host,
        "pid": module.pid,
        "provides": list(module.provides),
        "is_there": change.appeared,
    }
    return json.dumps(told).encode()
