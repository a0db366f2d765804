"""Logging of processes: everything to standard error, for people or as JSON lines."""

from __future__ import annotations

import logging
import sys

from tca_bus._errors import ConfigError, did_you_mean

LEVELS = ("debug", "info", "warning", "error", "critical")


def configure_logging(
    process: str, *, level: str = "info", json: bool = False, late: bool = False
) -> None:
    """Send the logs of this process, also those of stdlib loggers, to standard error.

    With ``json`` a line is an object, in which ``process`` stands; for people whoever starts the
    process shows its name. With ``late`` structlog is loaded with the first line of a stdlib logger
    and not set up before: right for what ends soon and as a rule logs nothing.

    Raises:
        ConfigError: There is no such level.
    """
    if level.lower() not in LEVELS:
        expected = f"one of {', '.join(LEVELS)}.{did_you_mean(level, LEVELS)}"
        raise ConfigError("--log-level", level, expected)
    handler = logging.StreamHandler(sys.stderr)
    formatter = _LateFormatter(process if json else None, json=json)
    if not late:
        formatter.make()
    handler.setFormatter(formatter)
    root = logging.getLogger()
    root.handlers[:] = [handler]
    root.setLevel(level.upper())


class _LateFormatter(logging.Formatter):
    """Makes what formats when it is needed."""

    def __init__(self, process: str | None, *, json: bool) -> None:
        super().__init__()
        self._process, self._json = process, json
        self._made: logging.Formatter | None = None

    def make(self) -> logging.Formatter:
        if self._made is None:
            from tca_bus._log_lines import formatter  # noqa: PLC0415 - loads structlog and rich

            self._made = formatter(self._process, json=self._json)
        return self._made

    def format(self, record: logging.LogRecord) -> str:
        return self.make().format(record)
