"""What the parts of one module share."""

from __future__ import annotations

import asyncio
import logging
import secrets
import time
from collections.abc import Callable, Coroutine
from dataclasses import dataclass, field
from typing import Any, Protocol

from tca_bus._errors import InvalidMessageError
from tca_bus._keys import Keys
from tca_bus._outlets import Outlets
from tca_bus._presence_feed import PresenceFeed
from tca_bus._session import Session

logger = logging.getLogger(__name__)


class Spawn(Protocol):
    """Runs a coroutine as a named task of the module's TaskGroup."""

    def __call__(self, coroutine: Coroutine[Any, Any, Any], *, name: str) -> asyncio.Task[Any]:
        """Start it."""
        ...


@dataclass
class Tally:
    """What a module has lost and refused, for its card."""

    invalid: int = 0
    counters: dict[str, Callable[[], int]] = field(default_factory=dict)

    def note_invalid(self, error: InvalidMessageError, *, sender: str) -> None:
        """Count a message that did not validate, and log it."""
        self.invalid += 1
        logger.warning("from %s: %s", sender, error)

    def dropped(self) -> dict[str, int]:
        """How many messages each queue has dropped; queues without a loss are left out."""
        counts = {name: count() for name, count in self.counters.items()}
        return {name: count for name, count in counts.items() if count}


@dataclass(frozen=True)
class Core:
    """The identity of a module, its session and what it knows of the others."""

    name: str
    incarnation: str
    keys: Keys
    session: Session
    presence: PresenceFeed
    spawn: Spawn
    tally: Tally
    outlets: Outlets


def new_incarnation() -> str:
    """An id that sorts by time of creation: milliseconds since the epoch and chance, in hex."""
    return f"{time.time_ns() // 1_000_000:012x}{secrets.token_hex(3)}"
