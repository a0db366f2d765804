"""Keeps on disk what the navigator knows, and finds it again at the next start."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from typing import Any

from navigate.keeping import StateFile
from navigate.navigator import Navigator

SAVE_SECONDS = 1.0
"""Wall seconds between two savings of the state."""

log = logging.getLogger(__name__)


def load(navigator: Navigator, kept: StateFile) -> None:
    """Go on from the state that was kept, if it is of this map and can be used."""
    state = kept.load()
    if state is None:
        return
    if state.get("map") != navigator.floor.plan.name:
        log.warning("the state that was kept is of map %s; not used", state.get("map"))
        return
    try:
        navigator.restore(state)
    except (KeyError, TypeError, ValueError) as error:
        log.warning("the state that was kept cannot be used: %r", error)


async def keep(navigator: Navigator, kept: StateFile, *, sensed: Callable[[], bool]) -> None:
    """Save about once a second what has changed, once the robot has ``sensed`` something.

    Where it cannot be written there is one word, until it can again.
    """
    saved, fails = dict[str, Any](), False
    while True:
        await asyncio.sleep(SAVE_SECONDS)
        state = navigator.snapshot()
        if state == saved or not sensed():
            continue
        try:
            await asyncio.to_thread(kept.save, state)
            saved, fails = state, False
        except OSError as error:
            if not fails:
                log.warning("%s cannot be written: %s", kept.path, error.strerror)
            fails = True
