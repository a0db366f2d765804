"""Modules that must be the only one of their name: two robots would both publish the time."""

from __future__ import annotations

import asyncio

from tca_bus._errors import RefusedError
from tca_bus._presence import PresentModule
from tca_bus._presence_feed import PresenceFeed

VANISH_PATIENCE = 3.0
"""Wall seconds that one that was just killed has to vanish from the bus."""


async def be_only(presence: PresenceFeed, me: PresentModule, realm: str) -> None:
    """Wait, before ``me`` is announced, until no other module of its name is there.

    Raises:
        RefusedError: There still is one after `VANISH_PATIENCE`.
    """
    try:
        async with asyncio.timeout(VANISH_PATIENCE):
            await presence.until(lambda: not _others(presence, me))
    except TimeoutError:
        raise _second(_others(presence, me)[0], realm) from None


async def yield_to_older(presence: PresenceFeed, me: PresentModule, realm: str) -> None:
    """Run until an older module of the same name shows up: of two that start at once, it stays.

    Raises:
        RefusedError: There is one.
    """

    def older() -> list[PresentModule]:
        return [one for one in _others(presence, me) if one.incarnation < me.incarnation]

    await presence.until(lambda: bool(older()))
    raise _second(older()[0], realm)


def _others(presence: PresenceFeed, me: PresentModule) -> list[PresentModule]:
    return [
        one
        for one in presence.table.modules()
        if one.name == me.name and one.incarnation != me.incarnation
    ]


def _second(other: PresentModule, realm: str) -> RefusedError:
    why = (
        f"process {other.pid} on {other.host} is {other.name} there; stop it, or choose another "
        "realm with --realm"
    )
    return RefusedError(f"a second {other.name} on realm {realm!r}", why)
