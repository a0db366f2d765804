"""Commands as users type them, but in the process of the test: a start costs half a second."""

from __future__ import annotations

import contextlib
import inspect
import io
import json
import logging
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest import mock

from cyclopts import App

from tca_bus.cli._complaining import complain
from tca_bus.cli._run import parsed


@dataclass(frozen=True)
class Ran:
    """How a command ended."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)

    @property
    def json_lines(self) -> list[Any]:
        return [json.loads(line) for line in self.out.splitlines()]


async def run_command(app: App, *words: str, **environment: str) -> Ran:
    """Run a command in the event loop of the test; one at a time, as they share the output."""
    out, err = io.StringIO(), io.StringIO()
    with (
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
        mock.patch.dict(os.environ, environment),
        _as_it_was(app),
    ):
        try:
            command, bound = parsed(app, list(words))
            result = command(*bound.args, **bound.kwargs)
            if inspect.isawaitable(result):
                result = await result
            code = result if isinstance(result, int) else 0
        except SystemExit as stopped:
            code = stopped.code if isinstance(stopped.code, int) else 1
        except (Exception, BaseExceptionGroup) as error:
            code = complain(error)
    return Ran(code, out.getvalue(), err.getvalue())


@contextlib.contextmanager
def _as_it_was(app: App) -> Iterator[None]:
    """Give it no standard input, and undo what it sets for its whole process."""
    root, config = logging.getLogger(), app.config
    handlers, level = root.handlers[:], root.level
    try:
        with Path(os.devnull).open(encoding="utf-8") as nobody, mock.patch("sys.stdin", nobody):
            yield
    finally:
        root.handlers[:], app.config = handlers, config
        root.setLevel(level)
