"""The launcher: several processes as one resource."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from types import TracebackType
from typing import Self, TextIO

from tca_bus._errors import ConfigError, TcaError, did_you_mean
from tca_bus._options import BusOptions
from tca_bus.launcher._child import Child
from tca_bus.launcher._logs import Console, LogFile, ProcessLog
from tca_bus.launcher._spec import ProcessSpec, start_order
from tca_bus.launcher._supervisor import Supervisor


def environment(options: BusOptions) -> dict[str, str]:
    """The options as the environment variables that every command line reads."""
    found = {
        "TCA_CONNECT": options.connect,
        "TCA_REALM": options.realm,
        "TCA_CLOCK": options.clock,
        "TCA_LINKS": options.links,
    }
    if options.keys is not None:
        found["TCA_KEYS"] = str(options.keys.absolute())
    if options.user is not None and options.password is not None:
        found["TCA_USER"] = options.user
        found["TCA_PASSWORD"] = options.password.get_secret_value()
    return found


class Launcher:
    """Runs processes for as long as its ``async with`` block lasts.

    Entering starts them, each once those before it are ready, and returns when all are. While
    the block runs, a process that ends is started again as its spec says; one that ends too
    often cancels the block, and leaving it raises `GaveUpError`. Leaving stops them in reverse
    order, whatever the reason, and returns when nothing of them is left. Every process leads a
    session of its own, so that Ctrl-C in the terminal reaches the launcher only, and inherits
    the read end of a pipe, named in ``TCA_PARENT_FD``: at its end of file the launcher was
    killed and the process has to end by itself.

    Args:
        specs: The processes, in the order in which they start.
        options: How they join the bus: given to them as ``TCA_CONNECT``, ``TCA_REALM``,
            ``TCA_CLOCK`` and, where there are any, ``TCA_KEYS``, ``TCA_USER`` and
            ``TCA_PASSWORD``.
        console: Where their lines are shown, each behind the name of its process.
        log_dir: Folder for one log file each, ``NAME.log``.

    Raises:
        ConfigError: two specs share a name, or one is to start after an unknown one.
        LauncherError: on entering, a process could not be started.
    """

    def __init__(
        self,
        specs: Sequence[ProcessSpec],
        options: BusOptions | None = None,
        *,
        console: TextIO | None = None,
        log_dir: Path | None = None,
    ) -> None:
        self._after = start_order(specs)
        self._specs = list(specs)
        self._options = options or BusOptions()
        self._console = Console(console, self._after) if console is not None else None
        self._log_dir = log_dir
        self._supervisors: dict[str, Supervisor] = {}
        self._group = asyncio.TaskGroup()
        self._pipe: tuple[int, int] | None = None

    async def __aenter__(self) -> Self:
        await self._group.__aenter__()
        self._pipe = os.pipe()
        try:
            self._supervisors = {spec.name: self._supervisor(spec) for spec in self._specs}
            await self._start_all()
        except BaseException as error:
            await self.__aexit__(type(error), error, error.__traceback__)
            raise
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            await self._stop_all()
        finally:
            self._close()
            await self._leave_group(error)

    def pid(self, name: str) -> int | None:
        """The id of a process; None while it is down."""
        return self._named(name).pid

    def restarts(self, name: str) -> int:
        """How often a process was started again and became ready."""
        return self._named(name).restarts

    def logs(self, name: str) -> list[str]:
        """The last lines that a process wrote, the newest last; some hundreds at most."""
        return self._named(name).log.tail()

    async def wait_restarted(
        self, name: str, *, beyond: int | None = None, timeout: float = 30.0
    ) -> int:
        """Wait until a process is ready after one more restart.

        Args:
            name: The process.
            beyond: The number of restarts to exceed; that of now when None.
            timeout: Wall seconds.

        Returns:
            The number of its restarts.

        Raises:
            TimedOutError: it was not within ``timeout``.
        """
        supervisor = self._named(name)
        count = supervisor.restarts if beyond is None else beyond
        return await supervisor.wait_restarted(beyond=count, timeout=timeout)

    async def serve_forever(self) -> None:
        """Wait until cancelled: by the user, or because a process was given up."""
        await asyncio.get_running_loop().create_future()

    def _named(self, name: str) -> Supervisor:
        try:
            return self._supervisors[name]
        except KeyError:
            known = ", ".join(self._after)
            hint = did_you_mean(name, self._after)
            raise ConfigError("process", name, f"one of {known}.{hint}") from None

    def _supervisor(self, spec: ProcessSpec) -> Supervisor:
        file = LogFile(self._log_dir / f"{spec.name}.log") if self._log_dir is not None else None
        log = ProcessLog(spec.name, self._console, file)
        return Supervisor(spec, log, lambda: self._spawn(spec, log))

    async def _spawn(self, spec: ProcessSpec, log: ProcessLog) -> Child:
        assert self._pipe is not None
        return await Child.spawn(
            spec,
            env=environment(self._options),
            parent_fd=self._pipe[0],
            take=log.write,
            group=self._group,
        )

    async def _start_all(self) -> None:
        try:
            async with asyncio.TaskGroup() as starting:
                for supervisor in self._supervisors.values():
                    name = supervisor.spec.name
                    starting.create_task(self._start(supervisor), name=f"launcher.{name}.start")
        except BaseExceptionGroup as errors:
            raise _most_telling(errors) from errors

    async def _start(self, supervisor: Supervisor) -> None:
        name = supervisor.spec.name
        for earlier in self._after[name]:
            await self._supervisors[earlier].started.wait()
        await supervisor.start()
        self._group.create_task(supervisor.watch(), name=f"launcher.{name}.watch")

    async def _stop_all(self) -> None:
        for supervisor in self._supervisors.values():
            supervisor.disarm()
        try:
            for supervisor in reversed(self._supervisors.values()):
                await supervisor.stop()
        finally:
            for supervisor in self._supervisors.values():
                supervisor.kill()
            for supervisor in self._supervisors.values():
                await supervisor.wait_ended()

    def _close(self) -> None:
        for supervisor in self._supervisors.values():
            supervisor.log.close()
        for end in self._pipe or ():
            os.close(end)
        self._pipe = None

    async def _leave_group(self, error: BaseException | None) -> None:
        cancelled = error if isinstance(error, asyncio.CancelledError) else None
        kind = type(cancelled) if cancelled is not None else None
        try:
            await self._group.__aexit__(kind, cancelled, None)
        except BaseExceptionGroup as errors:
            raise _most_telling(errors) from error


def _most_telling(errors: BaseExceptionGroup[BaseException]) -> BaseException:
    flat = list(_flatten(errors))
    own = [error for error in flat if isinstance(error, TcaError)]
    return (own or flat)[0]


def _flatten(errors: BaseExceptionGroup[BaseException]) -> Iterable[BaseException]:
    for error in errors.exceptions:
        if isinstance(error, BaseExceptionGroup):
            yield from _flatten(error)
        else:
            yield error
