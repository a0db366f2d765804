"""Zenoh's sessions: opened with patience, closed always; one for a module, or one for many.

A session has threads of its own for what arrives, is told of every token, and keeps a connection.
Hundreds of modules in one process are better off with one in common: the first that joins opens it,
and the last that leaves closes it.
"""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable
from weakref import WeakKeyDictionary

import zenoh
from zenoh.handlers import Callback

from tca_bus._bridge import Mailbox
from tca_bus._credentials import credentials_for
from tca_bus._diagnosis import Door, explain
from tca_bus._errors import BusGoneError, RefusedError
from tca_bus._joining import client_config, session_config
from tca_bus._lingering import PromptClosing
from tca_bus._options import BusOptions
from tca_bus._token_watch import TokenWatch
from tca_bus._uninterrupted import uninterrupted

logger = logging.getLogger(__name__)

MAILBOX_SIZE = 4096

TransportListener = Callable[[bool], None]


class Link:
    """An open Zenoh session, and whether its router can be reached."""

    def __init__(self, session: zenoh.Session, endpoint: str) -> None:
        self.zenoh = session
        self.endpoint = endpoint
        self.up = asyncio.Event()
        self.up.set()
        self._listeners: list[TransportListener] = []
        self._watches: dict[str, TokenWatch] = {}
        self._closing = PromptClosing()
        box = Mailbox[zenoh.TransportEvent](self._transport_event, size=MAILBOX_SIZE)
        session.info.declare_transport_events_listener(Callback(box.post), history=False)

    def listen(self, listener: TransportListener) -> Callable[[], None]:
        """Call ``listener`` with True when the router is back, and with False when it is lost."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def tokens(self, key: str) -> TokenWatch:
        """The liveliness tokens on ``key``, watched for all modules of the session together."""
        if key not in self._watches:
            self._watches[key] = TokenWatch(self.zenoh, key, size=MAILBOX_SIZE)
        return self._watches[key]

    async def close(self) -> None:
        """Close the session."""
        self._closing.end()
        for watch in self._watches.values():
            watch.end()
        try:
            await asyncio.to_thread(self.zenoh.close)
        except zenoh.ZError as error:
            logger.warning("closing the Zenoh session: %s", error)

    def _transport_event(self, event: zenoh.TransportEvent) -> None:
        is_up = event.kind == zenoh.SampleKind.PUT
        if is_up:
            self._closing.link_opened()
        if event.transport.whatami != zenoh.WhatAmI.ROUTER or is_up == self.up.is_set():
            return
        if is_up:
            self.up.set()
            logger.info("router at %s is back", self.endpoint)
        else:
            self.up.clear()
            logger.warning("router at %s is lost", self.endpoint)
        for listener in list(self._listeners):
            listener(is_up)


async def open_link(options: BusOptions, module: str = "") -> Link:
    """Open a session of its own for ``module``.

    Raises:
        BusGoneError: No router answered within ``options.connect_timeout``.
        RefusedError: The router does not let ``module`` in.
        ConfigError: The keys of ``module`` cannot be used.
    """
    config = session_config(options, module)
    deadline = time.monotonic() + options.connect_timeout
    while True:
        try:
            return Link(await _open_once(config), options.connect)
        except zenoh.ZError as error:
            await _raise_if_shut_out(options, module)
            if time.monotonic() >= deadline:
                raise BusGoneError(options.connect) from error
        await asyncio.sleep(0.05)


class SharedLink:
    """The session that the modules of one event loop have in common, as long as there are any."""

    def __init__(self) -> None:
        self._link: Link | None = None
        self._users = 0
        self._turn = asyncio.Lock()

    async def take(self, options: BusOptions) -> Link:
        """The session, opened for the first who asks; each who took it gives it back.

        Raises:
            BusGoneError: No router answered within ``options.connect_timeout``.
        """
        try:
            async with asyncio.timeout(options.connect_timeout):
                link = await self._opened(options)
                try:
                    await link.up.wait()
                except asyncio.CancelledError:
                    await uninterrupted(self.give_back())
                    raise
                return link
        except TimeoutError as error:
            raise BusGoneError(options.connect) from error

    async def give_back(self) -> None:
        """Close the session with its last user."""
        async with self._turn:
            self._users -= 1
            if self._link is not None and not self._users:
                link, self._link = self._link, None
                await link.close()

    async def _opened(self, options: BusOptions) -> Link:
        async with self._turn:
            if self._link is None:
                self._link = await open_link(options)
            self._users += 1
            return self._link


_shared: WeakKeyDictionary[asyncio.AbstractEventLoop, dict[str, SharedLink]] = WeakKeyDictionary()


def shared_link(options: BusOptions) -> SharedLink:
    """The session to the router of ``options`` that modules of the running loop share."""
    here = _shared.setdefault(asyncio.get_running_loop(), {})
    return here.setdefault(options.connect, SharedLink())


async def _open_once(config: zenoh.Config) -> zenoh.Session:
    opening = asyncio.ensure_future(asyncio.to_thread(zenoh.open, config))
    try:
        return await asyncio.shield(opening)
    except asyncio.CancelledError:
        # The thread goes on; a session that nobody closes would hang the process at its end.
        await asyncio.wait([opening])
        if opening.exception() is None:
            await asyncio.to_thread(opening.result().close)
        raise


async def _raise_if_shut_out(options: BusOptions, module: str) -> None:
    door = Door(options.connect, credentials_for(options, module))
    config = client_config(options, module, once=True)
    why = await explain(door, lambda: zenoh.open(config).close())
    if why is not None:
        raise RefusedError(f"joining the bus at {options.connect} as {module!r}", why)
