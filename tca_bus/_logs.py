"""Logging of processes: everything to standard error, for people or as JSON lines."""

from __future__ import annotations

import logging

from tca_bus._errors import ConfigError, did_you_mean

LEVELS = ("debug", "info", "warning", "error", "critical")


def configure_logging(process: str, *, level: str = "info", json: bool = False) -> None:
    """Send the logs of this process, also those of stdlib loggers, to standard error.

    With ``json`` a line is an object, in which ``process`` stands; for people whoever starts the
    process shows its name.

    Raises:
        ConfigError: There is no such level.
    """
    if level.lower() not in LEVELS:
        expected = f"one of {', '.join(LEVELS)}.{did_you_mean(level, LEVELS)}"
        raise ConfigError("--log-level", level, expected)
    from tca_bus._log_lines import handler  # noqa: PLC0415 - only processes pay for structlog

    root = logging.getLogger()
    root.handlers[:] = [handler(process if json else None, json=json)]
    root.setLevel(level.upper())
