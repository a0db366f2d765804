"""Entering and leaving the bus: what a module owns, in the order in which it comes and goes."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from abc import ABC, abstractmethod
from collections.abc import Coroutine, Iterable
from types import TracebackType
from typing import Any, Self

from tca_bus._clock import Clock, WallClock
from tca_bus._core import Core, new_incarnation
from tca_bus._errors import ClosedError, ConfigError
from tca_bus._handlers import Handlers
from tca_bus._keys import Keys
from tca_bus._options import CHUNK_EXPECTED, CHUNK_PATTERN, BusOptions
from tca_bus._outlets import Outlets
from tca_bus._parts import Parts
from tca_bus._permissions import Permissions
from tca_bus._presence_feed import PresenceFeed
from tca_bus._readiness import Readiness
from tca_bus._session import Session
from tca_bus._tally import Tally
from tca_bus._work import Contexts

logger = logging.getLogger(__name__)


class Lifecycle(ABC):
    """Owns the session, the TaskGroup and the liveliness token of a module.

    Entered once, and left by the task that entered it.
    """

    def __init__(
        self,
        name: str,
        *,
        options: BusOptions | None = None,
        provides: Iterable[str] = (),
        requires: Iterable[str] = (),
        hold: bool = False,
        sole: bool = False,
    ) -> None:
        if not CHUNK_PATTERN.fullmatch(name):
            raise ConfigError("module name", name, CHUNK_EXPECTED)
        self.name = name
        self.incarnation = new_incarnation()
        self.options = options or BusOptions()
        self.sole = sole
        self.clock: Clock = WallClock()
        self._readiness = Readiness.declare(provides, requires, hold=hold)
        self.permissions = Permissions()
        self._handlers = Handlers(name)
        self._open: Parts | None = None
        self._is_used = False
        self._is_leaving = False
        self._background: set[asyncio.Task[Any]] = set()
        self._group = asyncio.TaskGroup()
        self._exits = contextlib.AsyncExitStack()

    async def __aenter__(self) -> Self:
        if self._is_used:
            raise ClosedError(self.name)
        self._is_used = True
        changed = self._transport_changed
        session = Session(self.options, on_transport=changed, module=self.name)
        async with contextlib.AsyncExitStack() as stack:
            await stack.enter_async_context(session)
            await self._group.__aenter__()
            stack.push_async_exit(self._leave)
            self._open = self._assemble(session)
            self.clock = await self._open.begin()
            self._exits = stack.pop_all()
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Cancel all handlers and background tasks, then close the session.

        Raises:
            Exception: What ended a background task, if that is why the module ends.
        """
        await self._exits.__aexit__(kind, error, trace)

    def start(self, coroutine: Coroutine[Any, Any, Any], *, name: str) -> asyncio.Task[Any]:
        """Run a background task; an exception in it ends the module and comes out of it.

        Raises:
            ClosedError: The module is not open, or about to close.
        """
        if self._is_leaving or not self._is_used:
            coroutine.close()
            raise ClosedError(self.name)
        try:
            task = self._group.create_task(coroutine, name=name)
        except RuntimeError as error:
            coroutine.close()
            raise ClosedError(self.name) from error
        self._background.add(task)
        task.add_done_callback(self._background.discard)
        return task

    @property
    def is_closed(self) -> bool:
        """Whether the module was left, or is about to be."""
        return self._is_leaving

    @property
    def core(self) -> Core:
        """What the parts of the module share, for tools that need the keys and the session.

        Raises:
            ClosedError: The module is not open, or about to close.
        """
        return self._parts.core

    @property
    def _parts(self) -> Parts:
        if self._open is None or self._is_leaving:
            raise ClosedError(self.name)
        return self._open

    def _assemble(self, session: Session) -> Parts:
        keys = Keys(self.options.realm)
        tally = Tally()
        permissions = self.permissions
        presence = PresenceFeed(session, keys, self.incarnation, tally, permissions)
        core = Core(
            self.name,
            self.incarnation,
            keys,
            session,
            presence,
            self.start,
            tally,
            Outlets(session),
            permissions,
        )
        return Parts(
            core=core,
            handlers=self._handlers,
            clock_kind=self.options.clock,
            contexts=self._contexts(),
            started=time.time(),
            readiness=self._readiness,
            sole=self.sole,
        )

    @abstractmethod
    def _contexts(self) -> Contexts:
        """What makes the contexts of this module's handlers."""

    def _transport_changed(self, is_up: bool) -> None:
        if self._open is not None and not self._is_leaving:
            self._open.transport_changed(is_up)

    async def _leave(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Cancel and await all tasks; a single failure comes out as itself."""
        self._is_leaving = True
        if self._open is not None:
            self._open.end()
        for task in list(self._background):
            task.cancel()
        # Told of an ordinary error the group would wrap it; it goes on by itself.
        is_cancelled = isinstance(error, asyncio.CancelledError)
        reason = (kind, error, trace) if is_cancelled else (None, None, None)
        try:
            await self._group.__aexit__(*reason)
        except BaseExceptionGroup as failures:
            cause = failures.exceptions[0] if len(failures.exceptions) == 1 else failures
        else:
            return
        if error is None or is_cancelled:
            raise cause
        logger.error("module %s: a background task failed too", self.name, exc_info=cause)
