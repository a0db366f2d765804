"""How log lines look: for people, or as JSON objects."""

from __future__ import annotations

import logging
import sys
from typing import Any

import structlog


def formatter(process: str | None, *, json: bool) -> logging.Formatter:
    """What makes lines of records, those of stdlib loggers too; sets structlog up for it.

    ``process`` stands in each line when it is not None.
    """
    shared = _shared_processors(process)
    structlog.configure(
        processors=[*shared, structlog.stdlib.ProcessorFormatter.wrap_for_formatter],
        logger_factory=structlog.stdlib.LoggerFactory(),
        wrapper_class=structlog.stdlib.BoundLogger,
        cache_logger_on_first_use=True,
    )
    strip = structlog.stdlib.ProcessorFormatter.remove_processors_meta
    return structlog.stdlib.ProcessorFormatter(
        foreign_pre_chain=shared, processors=[strip, *_renderers(json=json)]
    )


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
