"""One Zenoh session: opened with patience, closed always, with the state of its transport."""

from __future__ import annotations

import asyncio
import json
import logging
import re
import time
from collections.abc import Callable
from typing import Any, Self, TypeVar

import zenoh
from zenoh.handlers import Callback

from tca_bus._bridge import Answer, Arrivals, Mailbox, ask, call_on
from tca_bus._credentials import Credentials, credentials_for
from tca_bus._diagnosis import Door, explain
from tca_bus._errors import BusGoneError, ConfigError, RefusedError
from tca_bus._keys import Keys
from tca_bus._lingering import PromptClosing
from tca_bus._options import BusOptions
from tca_bus._wire import Payload

logger = logging.getLogger(__name__)

T = TypeVar("T")

OPEN_SLICE_MS = 500
"""One try to open; a cancelled module waits for at most this long."""

OPEN_TIMEOUT_MS = 10_000
"""Zenoh's own limit to one handshake. Beyond this host each try has `OPEN_SLICE_MS`: the kernel
sends what was lost again after 1, 2, 4, 8 s, so one that began while the network was cut would go
on long after it is healed."""

RETRY = {"period_init_ms": 100, "period_max_ms": 250, "period_increase_factor": 2}
"""How a lost link is opened again; presence counts on four tries a second."""

LEASE_MS, KEEP_ALIVES = 1800, 6
"""A peer that said nothing for so long is taken for gone by the other side; in that time it says
something so many times. The kernel repeats what was lost after 0.2, 0.6, 1.4 and 3 s; the lease
outlasts the third, so that a link healed before it goes on, and one healed later is over soon."""

LEASE = {"lease": LEASE_MS, "keep_alive": KEEP_ALIVES}

NO_SHARED_MEMORY = {"enabled": False}
"""Our messages are small, and a killed process would leave its pool of 16 MB in /dev/shm."""

LOOPBACK = "tcp/127.0.0.1:0"
"""Where a module with direct links listens: on a free port of this host only."""

_ON_THIS_HOST = re.compile(r"^unixsock-stream/|^[a-z]+/(127\.|localhost:|\[::1\]:)")

NO_MESSAGE, NOBODY = "tca.settle", "-"
"""A message that no module handles, asked for the sake of the answer that says so."""

SETTLE_TIMEOUT = 1.0
"""Wall seconds after which a look-up that got no answer counts as done."""

MAILBOX_SIZE = 4096


def session_config(options: BusOptions, module: str = "", *, once: bool = False) -> zenoh.Config:
    """The Zenoh configuration of a module: of a client, or of a peer when links are direct.

    With ``once`` it tries to connect once and does not wait for long.
    """
    if options.is_direct:
        return peer_config(options)
    return client_config(options, module, once=once)


def client_config(options: BusOptions, module: str = "", *, once: bool = False) -> zenoh.Config:
    """The Zenoh configuration of a client of one router, without discovery."""
    settings = {"mode": "client"} | _scouting(gossip=False)
    return _config(options, settings, module, once=once)


def peer_config(options: BusOptions) -> zenoh.Config:
    """The Zenoh configuration of a peer, which learns from the router where the others listen."""
    listening = {"mode": "peer", "listen": {"endpoints": [LOOPBACK], "exit_on_failure": True}}
    return _config(options, listening | _scouting(gossip=True))


def _scouting(*, gossip: bool) -> dict[str, Any]:
    methods = {"multicast": {"enabled": False}, "gossip": {"enabled": gossip}}
    return {"scouting": {"delay": 0, **methods}}


def _config(
    options: BusOptions, settings: dict[str, Any], module: str = "", *, once: bool = False
) -> zenoh.Config:
    credentials = credentials_for(options, module).transport
    common: dict[str, Any] = {
        "connect": {
            "endpoints": [options.connect],
            "timeout_ms": 0 if once else OPEN_SLICE_MS,
            "exit_on_failure": True,
            "retry": RETRY,
        },
        "timestamping": {"enabled": True},
        "transport": {
            **credentials,
            "link": {"tx": LEASE, **credentials["link"]},
            "shared_memory": NO_SHARED_MEMORY,
            "unicast": {
                "open_timeout": OPEN_SLICE_MS if once or _is_beyond(options) else OPEN_TIMEOUT_MS
            },
        },
    }
    try:
        return zenoh.Config.from_json5(json.dumps(settings | common))
    except zenoh.ZError as error:
        raise ConfigError("--connect", options.connect, f"a Zenoh endpoint ({error})") from error


def _is_beyond(options: BusOptions) -> bool:
    """Whether a network lies between this process and its router."""
    return _ON_THIS_HOST.match(options.connect) is None


class Session:
    """A Zenoh session as an async context manager.

    ``is_up`` says whether the router is reachable; `connected` waits for it. ``can_send`` says
    whether what is sent now can arrive somewhere: direct links outlive the router. ``on_transport``
    is called on the loop with True when the router is back and False when it is lost.

    Raises:
        BusGoneError: On entering, no router answered within ``options.connect_timeout``.
        RefusedError: On entering, the router does not let ``module`` in.
        ConfigError: On entering, the keys of ``module`` cannot be used.
    """

    def __init__(
        self, options: BusOptions, *, on_transport: Callable[[bool], None], module: str = ""
    ) -> None:
        self._options = options
        self._module = module
        self._on_transport = on_transport
        self._up = asyncio.Event()
        self.is_direct = options.is_direct
        self.can_send = False
        self.zenoh: zenoh.Session
        self._arrivals: Arrivals | None = None
        self._closing: PromptClosing | None = None
        # Zenoh's own flag waits for a lock without giving up the GIL: if a callback that runs
        # under that lock needs the GIL, both wait for ever.
        self.is_closed = False
        self.outages = 0

    async def __aenter__(self) -> Self:
        self.zenoh = await self._open()
        self._arrivals = Arrivals(batch=1) if self._options.keeps_order else None
        self._set_up(is_up=True)
        self._closing = PromptClosing(self.zenoh)
        box = Mailbox[zenoh.TransportEvent](self._transport_event, size=MAILBOX_SIZE)
        self.zenoh.info.declare_transport_events_listener(Callback(box.post), history=False)
        return self

    async def __aexit__(self, *_: object) -> None:
        await uninterrupted(self.close())

    async def close(self) -> None:
        """Close the session; harmless when it is closed."""
        self._up.clear()
        self.can_send = False
        self.is_closed = True
        if self._closing is not None:
            self._closing.end()
        try:
            await asyncio.to_thread(self.zenoh.close)
        except zenoh.ZError as error:
            logger.warning("closing the Zenoh session: %s", error)

    @property
    def is_up(self) -> bool:
        """Whether the router is reachable."""
        return self._up.is_set()

    @property
    def credentials(self) -> Credentials:
        """With what the module joined."""
        return credentials_for(self._options, self._module)

    @property
    def endpoint(self) -> str:
        """The endpoint of the router."""
        return self._options.connect

    async def connected(self) -> None:
        """Wait until the router is reachable."""
        await self._up.wait()

    async def sendable(self) -> None:
        """Wait until what is sent can arrive somewhere."""
        if not self.is_direct:
            await self._up.wait()

    def has_router(self) -> bool:
        """Ask Zenoh itself, for the moment before its event has arrived."""
        return bool(self.zenoh.info.routers_zid())

    def mailbox(
        self,
        consume: Callable[[T], int | None],
        *,
        size: int = MAILBOX_SIZE,
        refuse: Callable[[T], None] | None = None,
    ) -> tuple[Mailbox[T], Callback[T]]:
        """A mailbox, and the Zenoh callback that posts to it.

        Where the options ask for order, it keeps one with all others of this session.
        """
        box = Mailbox(consume, size=size, refuse=refuse, arrivals=self._arrivals)
        return box, Callback(box.post, indirect=self._arrivals is None)

    async def ask(
        self, key: str, payload: Payload, *, attachment: bytes, timeout: float
    ) -> Answer | None:
        """Send one query; see `tca_bus._bridge.ask`."""
        return await ask(
            self.zenoh,
            key,
            payload,
            attachment=attachment,
            timeout=timeout,
            arrivals=self._arrivals,
        )

    def put(self, key: str, payload: Payload, *, attachment: bytes, block: bool) -> None:
        """Publish; with ``block`` it is not dropped when the link is congested."""
        control = zenoh.CongestionControl.BLOCK if block else zenoh.CongestionControl.DROP
        self.zenoh.put(
            key,
            payload.data,
            encoding=payload.encoding,
            attachment=attachment,
            congestion_control=control,
        )

    async def settle(self, key: str) -> None:
        """Wait until the others have seen all declarations so far.

        A declaration returns before anybody knows of it. What is sent on one link arrives in
        order, so the answer to a look-up of liveliness ``key`` means that the router has it. A
        module that is linked directly would answer that from what it knows; it is asked itself.
        """
        loop = asyncio.get_running_loop()
        done = asyncio.Event()
        answered = Callback(_ignore, lambda: call_on(loop, done.set), indirect=False)
        if self.is_direct:
            everybody = Keys(self._options.realm).query_to_all(NO_MESSAGE, NOBODY)
            target = zenoh.QueryTarget.ALL
            self.zenoh.get(everybody, answered, target=target, timeout=SETTLE_TIMEOUT)
        else:
            self.zenoh.liveliness().get(key, answered, timeout=SETTLE_TIMEOUT)
        await done.wait()

    async def _open(self) -> zenoh.Session:
        config = session_config(self._options, self._module)
        deadline = time.monotonic() + self._options.connect_timeout
        while True:
            try:
                return await _open_once(config)
            except zenoh.ZError as error:
                await self._raise_if_shut_out()
                if time.monotonic() >= deadline:
                    raise BusGoneError(self._options.connect) from error
            await asyncio.sleep(0.05)

    async def _raise_if_shut_out(self) -> None:
        options = self._options
        door = Door(options.connect, self.credentials)
        config = client_config(options, self._module, once=True)
        why = await explain(door, lambda: zenoh.open(config).close())
        if why is not None:
            raise RefusedError(f"joining the bus at {options.connect} as {self._module!r}", why)

    def _transport_event(self, event: zenoh.TransportEvent) -> None:
        if event.transport.whatami != zenoh.WhatAmI.ROUTER:
            return
        is_up = event.kind == zenoh.SampleKind.PUT
        if is_up == self._up.is_set():
            return
        self._set_up(is_up=is_up)
        if is_up:
            logger.info("router at %s is back", self.endpoint)
        else:
            self.outages += 1
            logger.warning("router at %s is lost", self.endpoint)
        self._on_transport(is_up)

    def _set_up(self, *, is_up: bool) -> None:
        if is_up:
            self._up.set()
        else:
            self._up.clear()
        self.can_send = is_up or self.is_direct


def _ignore(_: zenoh.Reply) -> None:
    """Take a reply that says nothing new."""


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
