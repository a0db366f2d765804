"""The places in a module's resources: handlers that share one exclude each other here too.

Central holds back what has no place. This is the module's own bound, for the moments in which
central does not know the module yet, and for queries and informs, which do not pass central.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass, field

from tca_bus._errors import ConfigError, did_you_mean
from tca_bus._options import CHUNK_EXPECTED, CHUNK_PATTERN
from tca_bus._protocol import ProvidedResource


@dataclass(frozen=True, slots=True)
class Resource:
    """What handlers of one module share; see `Module.resource`."""

    name: str
    capacity: int
    pending: int | None

    def card(self) -> ProvidedResource:
        """The resource as others see it."""
        return ProvidedResource(name=self.name, capacity=self.capacity, pending=self.pending)


@dataclass
class Resources:
    """The resources of one module, and the places in them. ``own`` is the module's name."""

    own: str = ""
    _by_name: dict[str, Resource] = field(default_factory=dict)
    _places: dict[tuple[str, str], asyncio.Semaphore] = field(default_factory=dict)

    def add(self, name: str, *, capacity: int, pending: int | None) -> Resource:
        """Make a resource.

        Raises:
            ConfigError: There is one of the name, or name, capacity or limit are of no use.
        """
        if not CHUNK_PATTERN.fullmatch(name):
            raise ConfigError("resource", name, CHUNK_EXPECTED)
        if name in self._by_name:
            raise ConfigError("resource", name, "a name that this module has not given yet")
        if capacity < 1:
            raise ConfigError("capacity", capacity, "at least 1")
        check_pending(pending)
        resource = Resource(name, capacity, pending)
        self._by_name[name] = resource
        return resource

    def check(self, name: str) -> None:
        """Refuse a resource that was not made.

        Raises:
            ConfigError: It says what looks like it.
        """
        if name not in self._by_name:
            near = did_you_mean(name, self._by_name)
            raise ConfigError("resource", name, f"one made before by Module.resource.{near}")

    def cards(self) -> list[ProvidedResource]:
        """The resources as others see them."""
        return [resource.card() for resource in self._by_name.values()]

    def capacity(self, name: str) -> int:
        """How many handlers of a resource run at once."""
        return self._by_name[name].capacity

    @contextlib.asynccontextmanager
    async def place(self, message: str, capacity: int, resource: str | None) -> AsyncIterator[None]:
        """Hold a place for a handler of a message while the block runs."""
        async with contextlib.AsyncExitStack() as stack:
            if resource is None:
                await stack.enter_async_context(self._place("message", message, capacity))
            for shared in dict.fromkeys((resource, self.own)):
                if shared is not None and shared in self._by_name:
                    await stack.enter_async_context(self._shared(shared))
            yield

    def _shared(self, name: str) -> asyncio.Semaphore:
        return self._place("resource", name, self._by_name[name].capacity)

    def _place(self, kind: str, name: str, capacity: int) -> asyncio.Semaphore:
        return self._places.setdefault((kind, name), asyncio.Semaphore(capacity))


def check_pending(pending: int | None) -> None:
    """Refuse a limit that lets nothing wait or is negative.

    Raises:
        ConfigError: It is below 1.
    """
    if pending is not None and pending < 1:
        raise ConfigError("pending", pending, "at least 1, or None for no limit")
