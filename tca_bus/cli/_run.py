"""Running a command: the event loop, signals, errors and exit codes."""

from __future__ import annotations

import asyncio
import inspect
import logging
import os
import signal
import sys
from collections.abc import Callable, Coroutine, Iterator, Sequence
from typing import Any, NoReturn

from cyclopts import App
from cyclopts.config import Dict
from pydantic import ValidationError

from tca_bus._errors import ConfigError, InvalidMessageError, TcaError
from tca_bus._problems import problems_of
from tca_bus.cli._config import config_path, file_values

logger = logging.getLogger(__name__)

PARENT_FD = "TCA_PARENT_FD"
"""Environment variable with the number of a pipe that closes when the launcher is gone."""

INTERRUPTED = 6
"""Exit code of a command that was cancelled before it was done."""


def run_app(app: App, tokens: Sequence[str] | None = None) -> NoReturn:
    """Run one command and end the process with the exit code of the design.

    The command may be a plain or an async function; an integer that it returns is the exit
    code. SIGINT and SIGTERM cancel an async command, a second SIGINT ends the process at once.
    After SIGTERM, or when the parent named by ``TCA_PARENT_FD`` is gone, the code is 0 unless
    the command returned another.
    """
    arguments = list(sys.argv[1:] if tokens is None else tokens)
    try:
        code = _guarded(app, arguments)
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader has what it wanted; the interpreter must not flush into the pipe again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 0
    sys.exit(code)


def _guarded(app: App, tokens: list[str]) -> int:
    try:
        return _run(app, tokens)
    except TcaError as error:
        return _complain(error)
    except ValidationError as error:
        # A message that was made of what the user typed; -v shows where.
        logger.debug("no valid message", exc_info=error)
        return _complain(InvalidMessageError(error.title, problems_of(error)))
    except BaseExceptionGroup as group:
        found = next(_errors_in(group), None)
        if found is None:
            raise
        return _complain(found)
    except KeyboardInterrupt:
        return INTERRUPTED


def _run(app: App, tokens: list[str]) -> int:
    commands, apps, _ = app.parse_commands(tokens)
    for called in apps:
        if called.default_command is not None and not called.name[0].startswith("-"):
            # Its docstring says more than the summary that stands for it until it is imported.
            called.help = None
    path = config_path(tokens)
    if path is not None:
        values = file_values(path, app.name[0], commands)
        app.config = (Dict(values, use_commands_as_keys=False, source=str(path)),)
    command, bound, _ = app.parse_args(tokens)
    if inspect.iscoroutinefunction(command):
        result = _run_async(lambda: command(*bound.args, **bound.kwargs))
    else:
        result = command(*bound.args, **bound.kwargs)
    return result if isinstance(result, int) else 0


def _complain(error: TcaError) -> int:
    sys.stderr.write(f"error: {error}\n")
    return error.exit_code


def _errors_in(group: BaseExceptionGroup[Any]) -> Iterator[TcaError]:
    for error in group.exceptions:
        if isinstance(error, TcaError | BrokenPipeError):
            if isinstance(error, BrokenPipeError):
                raise error
            yield error
        elif isinstance(error, BaseExceptionGroup):
            yield from _errors_in(error)


def _run_async(make: Callable[[], Coroutine[Any, Any, Any]]) -> Any:
    with asyncio.Runner(loop_factory=_loop_factory()) as runner:
        return runner.run(_Supervised(make).run())


def _loop_factory() -> Callable[[], asyncio.AbstractEventLoop]:
    try:
        import uvloop  # noqa: PLC0415 - absent on Windows
    except ImportError:
        return asyncio.new_event_loop
    return uvloop.new_event_loop


class _Supervised:
    """One async command, cancelled by signals and by the end of the parent process."""

    def __init__(self, make: Callable[[], Coroutine[Any, Any, Any]]) -> None:
        self._make = make
        self._code: int | None = None
        self._task: asyncio.Task[Any] | None = None

    async def run(self) -> Any:
        """Run the command; after a stop its own result counts, else the stop's exit code."""
        loop = asyncio.get_running_loop()
        self._task = loop.create_task(self._make(), name="command")
        loop.add_signal_handler(signal.SIGINT, self._interrupt)
        loop.add_signal_handler(signal.SIGTERM, self._stop, 0)
        parent = self._watch_parent(loop)
        try:
            return await self._task
        except asyncio.CancelledError:
            if self._code is None:
                raise
            return self._code
        finally:
            if parent is not None:
                loop.remove_reader(parent)

    def _interrupt(self) -> None:
        if self._code is not None:
            os._exit(INTERRUPTED)
        self._stop(INTERRUPTED)

    def _stop(self, code: int) -> None:
        if self._code is None and self._task is not None:
            self._code = code
            self._task.cancel()

    def _watch_parent(self, loop: asyncio.AbstractEventLoop) -> int | None:
        text = os.environ.pop(PARENT_FD, "")
        if not text.isdigit():
            return None
        parent = int(text)
        try:
            os.set_inheritable(parent, False)
            loop.add_reader(parent, self._parent_said, loop, parent)
        except OSError as error:
            expected = f"an inherited end of a pipe ({error.strerror})"
            raise ConfigError(PARENT_FD, text, expected) from None
        return parent

    def _parent_said(self, loop: asyncio.AbstractEventLoop, parent: int) -> None:
        if os.read(parent, 4096):
            return
        loop.remove_reader(parent)
        self._stop(0)
