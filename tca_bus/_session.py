"""A module's view of its Zenoh session: what it declared there, and the state of the transport."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from typing import Any, Self, TypeVar

import zenoh
from zenoh.handlers import Callback

from tca_bus._bridge import Answer, Arrivals, Mailbox, ask, call_on
from tca_bus._credentials import Credentials, credentials_for
from tca_bus._keys import Keys
from tca_bus._link import MAILBOX_SIZE, Link, open_link, shared_link
from tca_bus._options import BusOptions
from tca_bus._token_watch import TokenWatch
from tca_bus._uninterrupted import uninterrupted
from tca_bus._wire import Payload

logger = logging.getLogger(__name__)

T = TypeVar("T")

Declared = zenoh.Subscriber[Any] | zenoh.Queryable[Any] | zenoh.Publisher | zenoh.LivelinessToken

D = TypeVar("D", bound=Declared)

NO_MESSAGE, NOBODY = "tca.settle", "-"
"""A message that no module handles, asked for the sake of the answer that says so."""

SETTLE_TIMEOUT = 1.0
"""Wall seconds after which a look-up that got no answer counts as done."""


class Session:
    """A Zenoh session as an async context manager, of its own or shared as the options say.

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
        self._link: Link
        self._declared: set[Declared] = set()
        self._arrivals: Arrivals | None = None
        # Zenoh's own flag waits for a lock without giving up the GIL: if a callback that runs
        # under that lock needs the GIL, both wait for ever.
        self.is_closed = False
        self.outages = 0

    async def __aenter__(self) -> Self:
        options = self._options
        if options.is_shared:
            self._link = await shared_link(options).take(options)
        else:
            self._link = await open_link(options, self._module)
        self.zenoh = self._link.zenoh
        self._arrivals = Arrivals(batch=1) if options.keeps_order else None
        self._set_up(is_up=True)
        self._listen_no_longer = self._link.listen(self._transport_changed)
        return self

    async def __aexit__(self, *_: object) -> None:
        await uninterrupted(self.close())

    async def close(self) -> None:
        """Close the session, or take away what was declared on a shared one; once is enough."""
        if self.is_closed:
            return
        self._up.clear()
        self.can_send = False
        self.is_closed = True
        self._listen_no_longer()
        if self._options.is_shared:
            await asyncio.to_thread(self._undeclare_all)
            await shared_link(self._options).give_back()
        else:
            await self._link.close()

    def declare_subscriber(
        self, key: str, callback: Callback[zenoh.Sample]
    ) -> zenoh.Subscriber[Any]:
        """Declare a subscriber that ends with the session at the latest."""
        return self._keep(self.zenoh.declare_subscriber(key, callback))

    def declare_queryable(self, key: str, callback: Callback[Any]) -> zenoh.Queryable[Any]:
        """Declare a queryable that ends with the session at the latest."""
        return self._keep(self.zenoh.declare_queryable(key, callback))

    def declare_publisher(
        self, key: str, *, congestion_control: zenoh.CongestionControl
    ) -> zenoh.Publisher:
        """Declare a publisher that ends with the session at the latest."""
        return self._keep(self.zenoh.declare_publisher(key, congestion_control=congestion_control))

    def declare_token(self, key: str) -> zenoh.LivelinessToken:
        """Declare a liveliness token that ends with the session at the latest."""
        return self._keep(self.zenoh.liveliness().declare_token(key))

    def undeclare(self, declared: Declared) -> None:
        """End what was declared; what has ended with the session is left alone."""
        if not self.is_closed:
            self._declared.discard(declared)
            _end(declared)

    def tokens(self, key: str) -> TokenWatch:
        """The liveliness tokens on ``key``."""
        return self._link.tokens(key)

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
        # Each indirect one has a thread of its own, which hundreds of modules can do without.
        is_indirect = self._arrivals is None and not self._options.is_shared
        return box, Callback(box.post, indirect=is_indirect)

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

    def _transport_changed(self, is_up: bool) -> None:
        self._set_up(is_up=is_up)
        self.outages += not is_up
        self._on_transport(is_up)

    def _set_up(self, *, is_up: bool) -> None:
        if is_up:
            self._up.set()
        else:
            self._up.clear()
        self.can_send = is_up or self.is_direct

    def _keep(self, declared: D) -> D:
        self._declared.add(declared)
        return declared

    def _undeclare_all(self) -> None:
        # Tokens first: who is seen can be called.
        for declared in sorted(self._declared, key=_is_no_token):
            _end(declared)
        self._declared.clear()


def _end(declared: Declared) -> None:
    # Zenoh's own stubs leave it untyped.
    declared.undeclare()  # type: ignore[no-untyped-call]


def _is_no_token(declared: Declared) -> bool:
    return not isinstance(declared, zenoh.LivelinessToken)


def _ignore(_: zenoh.Reply) -> None:
    """Take a reply that says nothing new."""
