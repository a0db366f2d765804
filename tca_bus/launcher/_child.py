"""One running process: spawned as leader of its own session, ended with all its offspring."""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
from collections.abc import Mapping
from typing import Self

from tca_bus.launcher._logs import LineCutter, LineTaker
from tca_bus.launcher._spec import ProcessSpec

PARENT_FD = "TCA_PARENT_FD"
"""Environment variable with the number of a pipe that closes when the launcher is gone."""

_PROMPT_AFTER = 0.2
"""Seconds after which a line without an end is shown as it is: somebody may wait for it."""

_DRAIN = 1.0
"""Seconds that the output may outlive the process, when a stranger holds the pipe open."""


class Child:
    """A process that runs, or has ended. Made by `Child.spawn` only."""

    def __init__(self, spec: ProcessSpec, process: asyncio.subprocess.Process) -> None:
        self.spec, self._process = spec, process
        self.pid = process.pid
        self._pump: asyncio.Task[None] | None = None
        self._is_over = False

    @classmethod
    async def spawn(
        cls,
        spec: ProcessSpec,
        *,
        env: Mapping[str, str],
        parent_fd: int,
        take: LineTaker,
        group: asyncio.TaskGroup,
    ) -> Self:
        """Start the process; its lines are read by a task in ``group``.

        Raises:
            OSError: the program cannot be run.
        """
        read_end, write_end = os.pipe()
        try:
            process = await asyncio.create_subprocess_exec(
                *spec.argv,
                env={**os.environ, **env, **spec.env, PARENT_FD: str(parent_fd)},
                stdin=None if spec.stdin == "inherit" else asyncio.subprocess.DEVNULL,
                stdout=None if spec.output == "inherit" else write_end,
                stderr=write_end,
                pass_fds=(parent_fd,),
                start_new_session=True,
            )
        except BaseException:
            os.close(read_end)
            raise
        finally:
            os.close(write_end)
        child = cls(spec, process)
        child._read(read_end, take, group)
        return child

    @property
    def is_running(self) -> bool:
        """Whether the process has not been seen to end."""
        return self._process.returncode is None

    async def wait(self) -> int:
        """Wait for its end and for its last lines; return the code as in `subprocess`."""
        code = await self._process.wait()
        self.kill()
        self._is_over = True
        if self._pump is not None:
            await asyncio.wait({self._pump}, timeout=_DRAIN)
            self._pump.cancel()
        return code

    async def stop(self) -> int:
        """Ask it to end by SIGTERM, kill it after its grace; return as `wait` does."""
        if self.is_running:
            self._signal_all(signal.SIGTERM)
        try:
            async with asyncio.timeout(self.spec.grace):
                await self._process.wait()
        except TimeoutError:
            self.kill()
        return await self.wait()

    def kill(self) -> None:
        """Kill it, and what it started and did not take out of its session, at once."""
        # Once over, its number may be another's.
        if not self._is_over:
            self._signal_all(signal.SIGKILL)

    def _read(self, read_end: int, take: LineTaker, group: asyncio.TaskGroup) -> None:
        pump = _pump(read_end, take)
        try:
            self._pump = group.create_task(pump, name=f"launcher.{self.spec.name}.log")
        except RuntimeError:
            # The group is on its way out: nobody would see to the process.
            pump.close()
            os.close(read_end)
            self.kill()
            raise

    def _signal_all(self, which: signal.Signals) -> None:
        # macOS says EPERM where Linux says ESRCH for a group of which only zombies are left.
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self.pid, which)


async def _pump(read_end: int, take: LineTaker) -> None:
    reader = asyncio.StreamReader()
    pipe = os.fdopen(read_end, "rb", buffering=0)
    try:
        transport, _ = await asyncio.get_running_loop().connect_read_pipe(
            lambda: asyncio.StreamReaderProtocol(reader), pipe
        )
    except BaseException:
        pipe.close()
        raise
    try:
        await _cut(reader, take)
    finally:
        transport.close()


async def _cut(reader: asyncio.StreamReader, take: LineTaker) -> None:
    cutter = LineCutter()
    while True:
        try:
            async with asyncio.timeout(_PROMPT_AFTER if cutter.pending else None):
                data = await reader.read(65_536)
        except TimeoutError:
            lines = cutter.finish()
        else:
            lines = cutter.feed(data) if data else cutter.finish()
            if not data:
                _take_all(lines, take)
                return
        _take_all(lines, take)


def _take_all(lines: list[str], take: LineTaker) -> None:
    for line in lines:
        take(line)
