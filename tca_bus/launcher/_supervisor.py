"""Keeps one process running: first start, readiness, restarts, end."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable

from tca_bus._errors import TimedOutError
from tca_bus.launcher._child import Child
from tca_bus.launcher._errors import (
    GaveUpError,
    LauncherError,
    StartFailedError,
    WrongUseError,
    describe_exit,
)
from tca_bus.launcher._logs import ProcessLog
from tca_bus.launcher._restart import RestartHistory
from tca_bus.launcher._spec import ProcessSpec

TAIL_IN_ERRORS = 15
"""Lines of a process's output that an error quotes."""


class Supervisor:
    """The keeper of one process.

    `start` it, run `watch` as a task, `disarm` it before anything is stopped, then `stop` it.

    Args:
        spec: The process.
        log: Takes its lines and the supervisor's remarks.
        spawn: Starts one more try of the process.
    """

    def __init__(
        self, spec: ProcessSpec, log: ProcessLog, spawn: Callable[[], Awaitable[Child]]
    ) -> None:
        self.spec, self.log, self._spawn = spec, log, spawn
        self.started = asyncio.Event()
        self.restarts = 0
        self._child: Child | None = None
        self._since = 0.0
        self._disarmed = asyncio.Event()
        self._restarted = asyncio.Condition()

    @property
    def pid(self) -> int | None:
        """The process id; None when it does not run."""
        return self._child.pid if self._child is not None and self._child.is_running else None

    async def start(self) -> None:
        """Start it for the first time and wait until it is ready.

        Raises:
            LauncherError: it cannot be started, ended, or was not ready in time.
        """
        if self.spec.ready is not None:
            await self.spec.ready.before_first_start()
        child = await self._spawn_one()
        try:
            await self._until_ready(child)
        except _NotReadyError as error:
            await child.stop()
            kind = WrongUseError if error.code == WrongUseError.exit_code else StartFailedError
            raise kind(self.spec.name, str(error), self._tail()) from None
        self.started.set()

    async def watch(self) -> None:
        """Start it again whenever it ends, until `disarm`.

        Raises:
            GaveUpError: it ended too often.
            StartFailedError: it can no longer be run at all.
        """
        if self.spec.restart is None:
            return
        history = RestartHistory(self.spec.restart)
        while self._child is not None:
            code = await self._child.wait()
            if self._disarmed.is_set():
                return
            now = time.monotonic()
            delay = history.crashed(now=now, ran_for=now - self._since)
            if delay is None:
                window = self.spec.restart.window
                raise GaveUpError(self.spec.name, history.crashes, window, self._tail())
            self.log.remark(f"{describe_exit(code)}, starts again in {delay:.1f} s")
            if await self._disarmed_within(delay):
                return
            await self._start_again()

    def disarm(self) -> None:
        """Let its next end be final."""
        self._disarmed.set()

    async def stop(self) -> None:
        """End it, by force if it must be."""
        if self._child is None:
            return
        asked = self._child.is_running
        code = await self._child.stop()
        if asked:
            self.log.remark(describe_exit(code))

    def kill(self) -> None:
        """End it by force, now."""
        if self._child is not None:
            self._child.kill()

    async def wait_ended(self) -> None:
        """Wait until it is gone, after `kill`: else it would stay as a zombie of this process."""
        if self._child is not None:
            await self._child.wait()

    async def wait_restarted(self, *, beyond: int, timeout: float) -> int:
        """Wait until it was restarted more than ``beyond`` times and is ready.

        Returns:
            The number of restarts.

        Raises:
            TimedOutError: it was not within ``timeout`` seconds.
        """
        try:
            async with asyncio.timeout(timeout), self._restarted:
                await self._restarted.wait_for(lambda: self.restarts > beyond)
        except TimeoutError:
            raise TimedOutError(f"restart of {self.spec.name}", timeout) from None
        return self.restarts

    async def _spawn_one(self) -> Child:
        # Cancelled half-way, the process would run without anybody who knows of it.
        spawning = asyncio.ensure_future(self._spawn())
        try:
            self._child = await asyncio.shield(spawning)
        except asyncio.CancelledError:
            self._child = await spawning
            raise
        except OSError as error:
            raise StartFailedError(
                self.spec.name, f"{self.spec.argv[0]!r} cannot be run ({error.strerror})"
            ) from error
        self._since = time.monotonic()
        return self._child

    async def _start_again(self) -> None:
        child = await self._spawn_one()
        if self._disarmed.is_set():
            await child.stop()
            return
        try:
            await self._until_ready(child)
        except _NotReadyError as error:
            self.log.remark(str(error))
            await child.stop()
            return
        async with self._restarted:
            self.restarts += 1
            self._restarted.notify_all()

    async def _until_ready(self, child: Child) -> None:
        begun = time.monotonic()
        if self.spec.ready is not None:
            await self._race(child, self.spec.ready.wait(child.pid))
        self.log.remark(f"ready after {time.monotonic() - begun:.1f} s, pid {child.pid}")

    async def _race(self, child: Child, ready: Awaitable[None]) -> None:
        name = self.spec.name
        getting_ready = asyncio.ensure_future(ready)
        ending = asyncio.create_task(child.wait(), name=f"launcher.{name}.end")
        tries = {getting_ready, ending}
        try:
            await asyncio.wait(
                tries, timeout=self.spec.ready_timeout, return_when=asyncio.FIRST_COMPLETED
            )
            if getting_ready.done():
                getting_ready.result()
            elif ending.done():
                code = ending.result()
                raise _NotReadyError(f"it {describe_exit(code)} before it was ready", code)
            else:
                raise _NotReadyError(f"it was not ready within {self.spec.ready_timeout:g} s")
        finally:
            for one in tries:
                one.cancel()
            await asyncio.wait(tries)

    async def _disarmed_within(self, seconds: float) -> bool:
        try:
            async with asyncio.timeout(seconds):
                await self._disarmed.wait()
        except TimeoutError:
            return False
        return True

    def _tail(self) -> list[str]:
        return self.log.tail(TAIL_IN_ERRORS)


class _NotReadyError(LauncherError):
    """A try ended, with ``code``, or took too long before it was ready."""

    def __init__(self, text: str, code: int | None = None) -> None:
        self.code = code
        super().__init__(text)
