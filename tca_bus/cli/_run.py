"""Running a command: the event loop, signals, errors and exit codes."""

from __future__ import annotations

import inspect
import os
import sys
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from cyclopts import App
from cyclopts.config import Dict

from tca_bus.cli._config_path import config_path

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
    except KeyboardInterrupt:
        return INTERRUPTED
    except (Exception, BaseExceptionGroup) as error:
        from tca_bus.cli._complaining import complain  # noqa: PLC0415 - help needs no pydantic

        return complain(error)


def _run(app: App, tokens: list[str]) -> int:
    command, bound = parsed(app, tokens)
    if inspect.iscoroutinefunction(command):
        from tca_bus.cli._supervised import run_async  # noqa: PLC0415 - help needs no loop

        result = run_async(lambda: command(*bound.args, **bound.kwargs))
    else:
        result = command(*bound.args, **bound.kwargs)
    return result if isinstance(result, int) else 0


def parsed(app: App, tokens: list[str]) -> tuple[Callable[..., Any], inspect.BoundArguments]:
    """The command that the tokens call, and its arguments, those of ``--config`` too.

    Raises:
        SystemExit: They are no good use of it, which standard error says.
        ConfigError: The file of ``--config`` is no good.
    """
    commands, apps, _ = app.parse_commands(tokens)
    for name, called in zip(commands, apps[1:], strict=False):
        if called.default_command is not None and not name.startswith("-"):
            # Its docstring says more than the summary that stands for it until it is imported.
            called.help = None
    path = config_path(tokens)
    if path is not None:
        from tca_bus.cli._config import file_values  # noqa: PLC0415 - as complain

        values = file_values(path, app.name[0], commands)
        app.config = (Dict(values, use_commands_as_keys=False, source=str(path)),)
    command, bound, _ = app.parse_args(tokens)
    return command, bound
