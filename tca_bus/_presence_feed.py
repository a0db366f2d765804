"""Feeds the presence table from Zenoh's liveliness tokens."""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Callable, Coroutine
from dataclasses import dataclass, field
from typing import Any

import zenoh
from zenoh.handlers import Callback

from tca_bus._bridge import Mailbox, call_on
from tca_bus._keys import Keys, parse_presence
from tca_bus._presence import PresenceChange, PresenceTable, PresentModule
from tca_bus._session import MAILBOX_SIZE, Session
from tca_bus._tally import Tally

logger = logging.getLogger(__name__)

Listener = Callable[[PresenceChange], None]


@dataclass(frozen=True, slots=True)
class _Token:
    key: str
    is_put: bool


@dataclass
class PresenceFeed:
    """Keeps a `PresenceTable` up to date and tells listeners of changes, on the loop."""

    session: Session
    keys: Keys
    own: str
    tally: Tally
    table: PresenceTable = field(init=False)

    def __post_init__(self) -> None:
        self.table = PresenceTable(self.own)
        self._listeners: list[Listener] = []
        self._return_listeners: list[Callable[[PresentModule], None]] = []
        self._timer: asyncio.TimerHandle | None = None
        self._changed = asyncio.Event()
        self._warned_of: set[str] = set()
        self._loop = asyncio.get_running_loop()

    async def begin(self, timeout: float) -> None:
        """List the tokens that are there already, then declare the subscriber.

        Raises:
            TimeoutError: The router did not list them within ``timeout`` wall seconds.
        """
        box = Mailbox[_Token](self._take, size=MAILBOX_SIZE)

        def post(sample: zenoh.Sample) -> None:
            box.post(_token_of(sample))

        live = self.session.zenoh.liveliness()
        # Under a subscriber that has no history yet, Zenoh would answer the list with nothing.
        listed = await self._list(live, timeout)
        live.declare_subscriber(self.keys.all_presence(), Callback(post), history=True)
        for token in listed:
            self._take(token)
            # Suspect until the history names it too: it may have vanished in between.
            self._take(_Token(token.key, is_put=False))

    async def _list(self, live: zenoh.Liveliness, timeout: float) -> list[_Token]:
        listed = asyncio.Event()
        tokens: list[_Token] = []

        def on_reply(reply: zenoh.Reply) -> None:
            if reply.ok is not None:
                tokens.append(_token_of(reply.ok))

        done = Callback(on_reply, lambda: call_on(self._loop, listed.set), indirect=False)
        live.get(self.keys.all_presence(), done, timeout=timeout)
        await asyncio.wait_for(listed.wait(), timeout + 1.0)
        return tokens

    def end(self) -> None:
        """Stop the timer."""
        if self._timer is not None:
            self._timer.cancel()

    def listen(self, listener: Listener) -> Callable[[], None]:
        """Call ``listener`` with each change; gives a function that ends it."""
        self._listeners.append(listener)
        return lambda: self._listeners.remove(listener)

    def listen_to_returns(self, listener: Callable[[PresentModule], None]) -> None:
        """Call ``listener`` with each module whose token vanished and appeared again in time."""
        self._return_listeners.append(listener)

    def add(self, key: str) -> None:
        """Take a token of this module's own, without waiting for Zenoh to tell of it."""
        self._take(_Token(key, is_put=True))

    def transport_changed(self, is_up: bool) -> None:
        """The way to the router opened or closed."""
        if is_up:
            self.table.router_back(self._loop.time())
        else:
            self.table.router_lost(is_direct=self.session.is_direct)
        self._after_event([])

    async def until(self, condition: Callable[[], bool]) -> None:
        """Wait until ``condition``, which is about the table, holds."""
        while not condition():
            await self._changed.wait()

    def changed(self) -> Coroutine[Any, Any, Any]:
        """Wait for the next event about modules or the router, from the call on."""
        return self._changed.wait()

    def _take(self, token: _Token) -> None:
        try:
            module = parse_presence(token.key)
        except ValueError as error:
            self.tally.invalid += 1
            self.tally.complain("presence key", str(error))
            return
        if token.is_put:
            has_returned = self.table.state_of(module.incarnation) is None
            self._after_event(self.table.put(module))
            if has_returned:
                self._tell_return(module)
        else:
            self.table.delete(module, self._loop.time())
            self._after_event([])

    def _tell_return(self, module: PresentModule) -> None:
        for listener in self._return_listeners:
            listener(module)

    def _after_event(self, changes: list[PresenceChange]) -> None:
        # Waiters look again; the event is only a bell.
        self._changed.set()
        self._changed = asyncio.Event()
        if any(change.appeared for change in changes):
            self._warn_of_namesakes()
        for change in changes:
            for listener in list(self._listeners):
                listener(change)
        self._set_timer()

    def _warn_of_namesakes(self) -> None:
        for other in self.table.namesakes():
            if other.incarnation in self._warned_of:
                continue
            self._warned_of.add(other.incarnation)
            logger.warning(
                "another module is named %r, process %d on %s; messages go to the one that was "
                "started last. Stop one, or give it another name",
                *(other.name, other.pid, other.host),
            )

    def _set_timer(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None
        due = self.table.next_expiry()
        if due < math.inf:
            self._timer = self._loop.call_at(due, self._expire)

    def _expire(self) -> None:
        self._timer = None
        if self.session.is_up and not self.session.has_router():
            self.table.router_lost(is_direct=self.session.is_direct)
        self._after_event(self.table.expire(self._loop.time()))


def _token_of(sample: zenoh.Sample) -> _Token:
    return _Token(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)
