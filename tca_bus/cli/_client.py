"""How a command joins the bus, and what it asks of those that are there."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import TypeVar

from tca_bus import Module, NoHandlerError, PeerLostError, Query, TcaError, configure_logging
from tca_bus._presence import PresentModule
from tca_bus._protocol import Describe, ModuleCard, ProvidedMessage
from tca_bus.cli._flags import BusFlags, bus_options

CARD_TIMEOUT = 2.0
"""Wall seconds in which a module whose event loop turns introduces itself."""


CENTRAL_GRACE = 5.0
"""Wall seconds in which a central that is being started again comes back."""

RETRY_DELAY = 0.1

R = TypeVar("R")


class NoCentralError(NoHandlerError):
    """There is no central on the realm."""

    def __init__(self, realm: str) -> None:
        super().__init__("central")
        self.realm = realm

    def __str__(self) -> str:
        return (
            f"no central is on realm {self.realm!r}. Start it with 'tca central', or the whole "
            "office with 'rogue up'"
        )


@dataclass(frozen=True, slots=True)
class Seen:
    """A module that is present, and its card if it answers."""

    module: PresentModule
    card: ModuleCard | None

    @property
    def state(self) -> str:
        """``ready``; ``hung`` when the process does not answer; ``held`` and ``waiting`` before."""
        if self.card is None:
            return "hung"
        return self.module.stage or "ready"


@asynccontextmanager
async def joined(flags: BusFlags) -> AsyncIterator[Module]:
    """Join the bus for one command; logs only what is amiss unless told otherwise."""
    level = "warning" if flags.level == "info" else flags.level
    configure_logging("tca", level=level, json=flags.json, late=True)
    async with Module(f"tca-{os.getpid()}", options=bus_options(flags)) as module:
        yield module


async def ask_central(module: Module, question: Query[R], *, timeout: float = 10.0) -> R:
    """Ask central, again while it is being started again.

    Raises:
        NoCentralError: it is not there, and did not come back within a few seconds.
    """
    deadline = time.monotonic() + CENTRAL_GRACE
    while True:
        try:
            return await module.query(question, to="central", timeout=timeout)
        except (NoHandlerError, PeerLostError) as error:
            if time.monotonic() > deadline:
                raise NoCentralError(module.options.realm) from error
        await asyncio.sleep(RETRY_DELAY)


async def look_around(module: Module) -> list[Seen]:
    """All other modules, each asked to introduce itself."""
    others = [other for other in module.modules() if other.incarnation != module.incarnation]
    cards = await asyncio.gather(*(_card(module, other) for other in others))
    return [Seen(other, card) for other, card in zip(others, cards, strict=True)]


async def provided(module: Module, name: str) -> ProvidedMessage | None:
    """What the modules that handle a message say of it; None when they do not answer.

    Raises:
        NoHandlerError: nobody handles it; it names what looks like it.
    """
    present = module.modules()
    holders = [other for other in present if name in other.provides]
    if not holders:
        raise NoHandlerError(name, {known for other in present for known in other.provides})
    for holder in holders:
        card = await _card(module, holder)
        for message in card.provides if card else ():
            if message.name == name:
                return message
    return None


async def _card(module: Module, other: PresentModule) -> ModuleCard | None:
    try:
        return await module.query(Describe(), to=other, timeout=CARD_TIMEOUT)
    except TcaError:
        return None
