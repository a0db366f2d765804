"""Work that has to be done to its end though its task is cancelled."""

from __future__ import annotations

import asyncio
from typing import Any


async def uninterrupted(work: Any) -> None:
    """Finish ``work`` though cancelled meanwhile, then be cancelled."""
    task = asyncio.ensure_future(work)
    cancelled: asyncio.CancelledError | None = None
    while not task.done():
        try:
            await asyncio.wait([task])
        except asyncio.CancelledError as error:
            cancelled = error
    task.result()
    if cancelled is not None:
        raise cancelled
