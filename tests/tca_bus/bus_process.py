"""Processes of their own that join the bus of a test."""

from __future__ import annotations

import asyncio
import sys
from contextlib import asynccontextmanager
from pathlib import Path


@asynccontextmanager
async def joining(script, options, *words):
    """Run a script beside this file on a bus; it is killed at the end if it still runs."""
    path = Path(__file__).with_name(script)
    process = await asyncio.create_subprocess_exec(
        sys.executable, str(path), options.connect, options.realm, *words
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            process.kill()
        await process.wait()


def victim(options):
    """A module to be killed."""
    return joining("bus_victim.py", options, options.links)
