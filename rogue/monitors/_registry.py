"""The monitors that are on: begun when a plan needs them, ended when none does any more."""

from __future__ import annotations

import asyncio
import logging
from abc import ABC, abstractmethod
from collections.abc import Awaitable, Callable, Iterable

from rogue.monitors._needed import Kind, Monitor, Needed
from tca_bus import Clock

log = logging.getLogger(__name__)


class Watcher(ABC):
    """Watches all things of one kind that are needed; ``subjects`` are those at the moment."""

    kind: Kind

    def __init__(self) -> None:
        self.subjects: frozenset[str] = frozenset()

    @abstractmethod
    async def listen(self) -> None:
        """Hear of changes, until cancelled; begun when there is a first subject."""

    async def look(self, subjects: frozenset[str]) -> None:
        """See how things stand that are watched from now on; as a rule there is nothing to see."""
        del subjects


class MonitorRegistry:
    """Has watchers run while something depends on them.

    ``need`` is asked what is needed, at once and whenever `update` was called; ``review`` is
    awaited then, to compare what is known already with plans that have changed. In lockstep time
    stands still on ``clock`` meanwhile.
    """

    def __init__(
        self,
        watchers: Iterable[Watcher],
        need: Callable[[], Needed],
        review: Callable[[], Awaitable[None]],
        clock: Callable[[], Clock],
    ) -> None:
        self._watchers = list(watchers)
        self._need = need
        self._review = review
        self._clock = clock
        self._changed = asyncio.Event()
        self._listening: dict[Kind, asyncio.Task[None]] = {}
        self._on: dict[Monitor, tuple[str, ...]] = {}

    def update(self) -> None:
        """Say that what is needed may have changed."""
        self._changed.set()

    def on(self) -> dict[Monitor, tuple[str, ...]]:
        """The monitors that are on, each with the requests that depend on it."""
        return dict(self._on)

    async def run(self) -> None:
        """Begin and end monitors, until cancelled."""
        async with asyncio.TaskGroup() as group:
            while True:
                self._changed.clear()
                with self._clock().hold():
                    needed = self._need()
                    for watcher in self._watchers:
                        self._adjust(watcher, needed, group)
                    kinds = {watcher.kind for watcher in self._watchers}
                    self._on = {m: ids for m, ids in needed.items() if m.kind in kinds}
                    await self._review()
                await self._changed.wait()

    def _adjust(self, watcher: Watcher, needed: Needed, group: asyncio.TaskGroup) -> None:
        before = watcher.subjects
        watcher.subjects = frozenset(m.subject for m in needed if m.kind is watcher.kind)
        listening = self._listening.get(watcher.kind)
        if watcher.subjects and listening is None:
            name = f"rogue.monitor.{watcher.kind}"
            self._listening[watcher.kind] = group.create_task(watcher.listen(), name=name)
        elif not watcher.subjects and listening is not None:
            listening.cancel()
            del self._listening[watcher.kind]
        if new := watcher.subjects - before:
            log.debug("watching %s %s", watcher.kind, ", ".join(sorted(new)))
            group.create_task(self._look(watcher, new), name=f"rogue.look.{watcher.kind}")

    async def _look(self, watcher: Watcher, new: frozenset[str]) -> None:
        with self._clock().hold():
            await watcher.look(new)
