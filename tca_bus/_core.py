"""What the parts of one module share."""

from __future__ import annotations

import asyncio
import secrets
import time
from collections.abc import Coroutine
from dataclasses import dataclass, field
from typing import Any, Protocol

from tca_bus._keys import Keys
from tca_bus._outlets import Outlets
from tca_bus._permissions import Permissions
from tca_bus._presence_feed import PresenceFeed
from tca_bus._session import Session
from tca_bus._tally import Tally
from tca_bus._tapping import Tapping


class Spawn(Protocol):
    """Runs a coroutine as a named task of the module's TaskGroup."""

    def __call__(self, coroutine: Coroutine[Any, Any, Any], *, name: str) -> asyncio.Task[Any]:
        """Start it."""
        ...


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
    permissions: Permissions = field(default_factory=Permissions)
    tapping: Tapping = field(default_factory=Tapping)


def new_incarnation() -> str:
    """An id that sorts by time of creation: milliseconds since the epoch and chance, in hex."""
    return f"{time.time_ns() // 1_000_000:012x}{secrets.token_hex(3)}"
