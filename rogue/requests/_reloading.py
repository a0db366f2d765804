"""Reading the people directory again while the agent runs."""

from __future__ import annotations

import asyncio
import logging
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rogue.errors import DirectoryError
from rogue.requests._directory import Directory
from rogue.requests._entries import read_entries

log = logging.getLogger(__name__)


@contextmanager
def reread_on_hangup(directory: Directory, path: Path | None) -> Iterator[None]:
    """Read the directory's file again at each SIGHUP, as long as the block lasts.

    One that cannot be read changes nothing; what is wrong with it is logged.
    """

    def reread() -> None:
        try:
            directory.replace(read_entries(path))
        except DirectoryError as error:
            log.warning("%s; the one read before counts", error)
        else:
            log.info("the people directory was read again: %d people", len(directory.people))

    loop = asyncio.get_running_loop()
    loop.add_signal_handler(signal.SIGHUP, reread)
    try:
        yield
    finally:
        loop.remove_signal_handler(signal.SIGHUP)
