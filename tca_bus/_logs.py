"""Logging of processes: everything to standard error, for people or as JSON lines."""

from __future__ import annotations

import logging
import sys
from typing import Any

import structlog

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
    shared = _shared_processors(process if json else None)
    structlog.configure(
        processors=[*shared, structlog.stdlib.ProcessorFormatter.wrap_for_formatter],
        logger_factory=structlog.stdlib.LoggerFactory(),
        wrapper_class=structlog.stdlib.BoundLogger,
        cache_logger_on_first_use=True,
    )
    root = logging.getLogger()
    root.handlers[:] = [_handler(shared, json=json)]
    root.setLevel(level.upper())


def _handler(shared: list[Any], *, json: bool) -> logging.Handler:
    handler = logging.StreamHandler(sys.stderr)
    strip = structlog.stdlib.ProcessorFormatter.remove_processors_meta
    handler.setFormatter(
        structlog.stdlib.ProcessorFormatter(
            foreign_pre_chain=shared, processors=[strip, *_renderers(json=json)]
        )
    )
    return handler


def _shared_processors(process: str | None) -> list[Any]:
    def name_process(_logger: Any, _method: str, event: dict[str, Any]) -> dict[str, Any]:
        if process is not None:
            event["process"] = process
        return event

    return [
        structlog.contextvars.merge_contextvars,
        structlog.stdlib.add_log_level,
        structlog.stdlib.add_logger_name,
        structlog.stdlib.PositionalArgumentsFormatter(),
        structlog.processors.TimeStamper(fmt="iso", utc=True),
        name_process,
    ]


def _renderers(*, json: bool) -> list[Any]:
    if json:
        return [structlog.processors.dict_tracebacks, structlog.processors.JSONRenderer()]
    return [
        structlog.dev.ConsoleRenderer(
            colors=sys.stderr.isatty(),
            pad_event_to=0,
            exception_formatter=structlog.dev.plain_traceback,
        )
    ]
