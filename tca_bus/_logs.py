"""Logging of processes."""

from __future__ import annotations


def configure_logging(process: str, *, level: str = "info", json: bool = False) -> None:
    """Send all logs of this process to standard error, for people or as JSON lines."""
    raise NotImplementedError
