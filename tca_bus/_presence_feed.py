"""Feeds the presence table from Zenoh's liveliness tokens.

Tokens and transport events come on different threads, so their order is not certain after a loop
that hung; before a module is given up, Zenoh is asked whether its token is there after all.
"""

from __future__ import annotations

import asyncio
import logging
import math
from collections.abc import Callable, Coroutine
from dataclasses import dataclass, field
from typing import Any

from tca_bus._keys import Keys, parse_presence
from tca_bus._permissions import Permissions
from tca_bus._presence import PresenceChange, PresenceTable, PresentModule
from tca_bus._session import SETTLE_TIMEOUT, Session
from tca_bus._tally import Tally
from tca_bus._token_watch import Listing, Token

logger = logging.getLogger(__name__)

ASK_AGAIN = 0.1
"""Wall seconds before Zenoh is asked again that did not answer."""

Listener = Callable[[PresenceChange], None]


@dataclass
class PresenceFeed:
    """Keeps a `PresenceTable` up to date and tells listeners of changes, on the loop."""

    session: Session
    keys: Keys
    own: str
    tally: Tally
    permissions: Permissions = field(default_factory=Permissions)
    table: PresenceTable = field(init=False)

    def __post_init__(self) -> None:
        self.table = PresenceTable(self.own)
        self._listeners: list[Listener] = []
        self._return_listeners: list[Callable[[PresentModule], None]] = []
        self._timer: asyncio.TimerHandle | None = None
        self._timer_due = math.inf
        self._changed: asyncio.Event | None = None
        self._warned_of: set[str] = set()
        self._loop = asyncio.get_running_loop()
        self._own_token = ""
        self._is_asking = False
        self._vanished: set[str] = set()
        self._tokens = self.session.tokens(self.keys.all_presence())
        self._end_following: Callable[[], None] = _nothing

    async def begin(self, timeout: float) -> None:
        """Take the tokens that are there already, and follow what changes.

        Raises:
            TimeoutError: The router did not list them within ``timeout`` wall seconds.
        """
        listed, self._end_following = await self._tokens.follow(self._take, timeout)
        modules = [module for token in listed if (module := self._module_of(token))]
        # Suspects until Zenoh names them itself: one may have vanished in between.
        self._after_event(self.table.expect(modules, self._loop.time()))

    def end(self) -> None:
        """Follow no longer."""
        self._end_following()
        self._end_following = _nothing
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
        self._own_token = key
        self._tokens.take(Token(key, is_put=True))

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
            await self.changed()

    def changed(self) -> Coroutine[Any, Any, Any]:
        """Wait for the next event about modules or the router, from the call on."""
        if self._changed is None:
            self._changed = asyncio.Event()
        return self._changed.wait()

    def _take(self, token: Token) -> None:
        module = self._module_of(token)
        if module is None:
            return
        if token.is_put:
            self._put(module)
        else:
            if self._is_asking:
                self._vanished.add(token.key)
            due = self.table.delete(module, self._loop.time())
            self._tell([])
            self._ring_by(due)

    def _put(self, module: PresentModule) -> None:
        has_returned = self.table.state_of(module.incarnation) is None
        # Nobody is due the sooner for it, and there may be a thousand of them.
        self._tell(self.table.put(module, self._loop.time()))
        if has_returned:
            self._tell_return(module)

    def _module_of(self, token: Token) -> PresentModule | None:
        try:
            return self.permissions.vouch(parse_presence(token.key))
        except ValueError as error:
            self.tally.invalid += 1
            self.tally.complain("presence key", str(error))
            return None

    def _tell_return(self, module: PresentModule) -> None:
        for listener in self._return_listeners:
            listener(module)

    def _after_event(self, changes: list[PresenceChange]) -> None:
        self._tell(changes)
        self._set_timer()

    def _tell(self, changes: list[PresenceChange]) -> None:
        # Waiters look again; the event is only a bell.
        if self._changed is not None:
            self._changed.set()
            self._changed = None
        if not changes:
            return
        if any(change.appeared and self.table.is_own_name(change.module) for change in changes):
            self._warn_of_namesakes()
        for change in changes:
            for listener in list(self._listeners):
                listener(change)

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

    def _set_timer(self, *, earliest: float = 0.0) -> None:
        self._ring_by(max(self.table.next_expiry(), earliest), earliest)

    def _ring_by(self, due: float, earliest: float = 0.0) -> None:
        if due == math.inf or self._is_asking:
            return
        # One that rings too early is cheaper than a new one for each of a thousand tokens.
        if self._timer is not None and self._timer_due > due:
            self._timer.cancel()
            self._timer = None
        if self._timer is None:
            # One that is due already has no time in every event loop.
            self._timer_due = due
            self._timer = self._loop.call_at(due, self._timer_rang, earliest)

    def _timer_rang(self, earliest: float) -> None:
        self._timer = None
        if max(self.table.next_expiry(), earliest) > self._loop.time():
            self._set_timer(earliest=earliest)
        elif not self.session.is_closed:
            self._ask_before_giving_up()

    def _ask_before_giving_up(self) -> None:
        self._is_asking = True
        self._vanished.clear()
        asked = self._loop.time()
        self._tokens.ask(SETTLE_TIMEOUT, lambda listing: self._give_up(listing, asked))

    def _give_up(self, listing: Listing, asked: float) -> None:
        """Lose the suspects that were due when Zenoh was asked and that it does not know."""
        self._is_asking = False
        if self.session.is_closed:
            return
        for token in listing.tokens:
            if token.key not in self._vanished:
                self._put_back(token)
        if self._is_answered(listing):
            self._after_event(self.table.expire(asked))
        else:
            self._set_timer(earliest=self._loop.time() + ASK_AGAIN)

    def _is_answered(self, listing: Listing) -> bool:
        """Whether the router answered: without it Zenoh lists what it happens to know."""
        own = not self._own_token or self._own_token in {token.key for token in listing.tokens}
        return listing.is_whole and own and self.session.has_router()

    def _put_back(self, token: Token) -> None:
        module = self._module_of(token)
        if module is not None and self.table.state_of(module.incarnation) is None:
            self._put(module)


def _nothing() -> None:
    """End what has not begun."""
