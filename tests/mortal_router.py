"""A router that dies under its modules and rises again, for tests of what outlasts it."""

from __future__ import annotations

from typing import Any, Self

from tca_bus import BusOptions, Router
from tca_bus.testing import FREE_PORT


class MortalRouter:
    """A router that a test can kill and start again on its endpoint.

    It is linked to the routers at ``linked_to``; modules join it with its ``options``.
    """

    def __init__(self, *, linked_to: tuple[str, ...] = (), **options: Any) -> None:
        self._linked_to = linked_to
        self._facts = {"realm": "mortal", **options}
        self._router = Router(FREE_PORT, links=linked_to)
        self.options: BusOptions

    async def __aenter__(self) -> Self:
        await self._router.__aenter__()
        self.options = BusOptions(connect=self._router.endpoint, **self._facts)
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.die()

    async def die(self) -> None:
        await self._router.__aexit__(None, None, None)

    async def rise(self) -> None:
        self._router = Router(self.options.connect, links=self._linked_to)
        await self._router.__aenter__()
