"""When a started process counts as ready."""

from __future__ import annotations

import asyncio
import contextlib
import os
from typing import Protocol

from tca_bus._errors import BusGoneError
from tca_bus._module import Module
from tca_bus._options import BusOptions
from tca_bus._presence import Stage
from tca_bus.launcher._errors import PortInUseError

_PAUSE = 0.05
"""Seconds between two tries; the spec's ``ready_timeout`` bounds them as a whole."""


class Ready(Protocol):
    """A condition on a started process."""

    async def before_first_start(self) -> None:
        """Raise a `LauncherError` when there is no point in starting the process."""

    async def wait(self, pid: int) -> None:
        """Return once the process ``pid`` is ready; the caller bounds the wait."""


class RouterListening:
    """Ready when a router can be reached at the endpoint of ``options``."""

    def __init__(self, options: BusOptions) -> None:
        self._options = options.model_copy(update={"clock": "wall"})

    async def before_first_start(self) -> None:
        """Check that nobody listens there yet; only a TCP endpoint can be looked at.

        Raises:
            PortInUseError: somebody does.
        """
        if self._is_tcp and await self._accepts():
            raise PortInUseError(self._options.connect)

    async def wait(self, pid: int) -> None:  # noqa: ARG002 - a router has no token to compare
        """Return once the router takes connections."""
        look = self._accepts if self._is_tcp else self._lets_in
        while True:
            if await look():
                return
            await asyncio.sleep(_PAUSE)

    @property
    def _is_tcp(self) -> bool:
        return self._options.connect.startswith("tcp/")

    async def _accepts(self) -> bool:
        host, _, port = self._options.connect.removeprefix("tcp/").rpartition(":")
        try:
            _, writer = await asyncio.open_connection(host.strip("[]"), int(port))
        except OSError:
            return False
        writer.close()
        return True

    async def _lets_in(self) -> bool:
        try:
            async with Module(f"launcher-{os.getpid()}", options=self._options):
                return True
        except BusGoneError:
            return False


class ModulePresent:
    """Ready when a module's presence token is on the bus, put there by the process itself.

    A module that holds back what is sent to it is ready when it says so.

    Tokens of other processes do not count: neither that of a predecessor which the router has
    not yet missed, nor that of a namesake elsewhere. So the process must be the module, not a
    program that starts it.
    """

    def __init__(self, module: str, options: BusOptions) -> None:
        self._module = module
        self._options = options.model_copy(update={"clock": "wall"})

    async def before_first_start(self) -> None:
        """Nothing speaks against it."""

    async def wait(self, pid: int) -> None:
        """Return once the token of ``pid`` is there, however often the router goes away."""
        while True:
            with contextlib.suppress(BusGoneError):
                await self._watch(pid)
                return
            await asyncio.sleep(_PAUSE)

    async def _watch(self, pid: int) -> None:
        watcher = Module(f"launcher-{os.getpid()}-{self._module}", options=self._options)
        async with watcher, watcher.watch_modules() as changes:
            async for change in changes:
                module = change.module
                is_there = change.appeared and (module.name, module.pid) == (self._module, pid)
                if is_there and module.stage in {Stage.UNSAID, Stage.READY}:
                    return
