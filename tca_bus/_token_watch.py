"""Zenoh's liveliness tokens on one key, watched once for all modules of a session."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass, field

import zenoh
from zenoh.handlers import Callback

from tca_bus._bridge import Mailbox, call_on


@dataclass(frozen=True, slots=True)
class Token:
    """A liveliness token that appeared, or vanished."""

    key: str
    is_put: bool


@dataclass
class Listing:
    """What Zenoh answered when it was asked for all tokens, and whether it answered in time."""

    tokens: list[Token] = field(default_factory=list)
    is_whole: bool = True

    def add(self, reply: zenoh.Reply) -> None:
        """Take one of the answers."""
        if reply.ok is not None:
            self.tokens.append(_token_of(reply.ok))
        else:
            self.is_whole = False


Asked = Callable[[Listing], None]
Take = Callable[[Token], None]


class TokenWatch:
    """Keeps the tokens that are there, and hands what changes to all who follow, on the loop."""

    def __init__(self, session: zenoh.Session, key: str, *, size: int) -> None:
        self._session = session
        self._key = key
        self._loop = asyncio.get_running_loop()
        self._box = Mailbox[Token](self.take, size=size)
        self._there: dict[str, Token] = {}
        self._listed: dict[str, Token] = {}
        self._followers: list[Take] = []
        self._turn = asyncio.Lock()
        self._has_begun = False
        self._asking: list[Asked] = []
        self._is_asking = False

    async def follow(self, take: Take, timeout: float) -> tuple[list[Token], Callable[[], None]]:
        """Hand ``take`` all tokens from here on, beginning with those that are there.

        Gives those that Zenoh listed and has yet to name itself, and a function that ends it.

        Raises:
            TimeoutError: The router did not list them within ``timeout`` wall seconds.
        """
        async with self._turn:
            if not self._has_begun:
                await self._begin(timeout)
        for token in self._there.values():
            take(token)
        self._followers.append(take)
        return list(self._listed.values()), lambda: self._followers.remove(take)

    async def _begin(self, timeout: float) -> None:
        # Under a subscriber that has no history yet, Zenoh would answer the list with nothing.
        found: list[Listing] = []
        listed = asyncio.Event()

        def take(listing: Listing) -> None:
            found.append(listing)
            listed.set()

        self.ask(timeout, take)
        async with asyncio.timeout(timeout + 1.0):
            await listed.wait()
        self._has_begun = True
        self._listed = {token.key: token for token in found[0].tokens}

        def post(sample: zenoh.Sample) -> None:
            self._box.post(_token_of(sample))

        live = self._session.liveliness()
        live.declare_subscriber(self._key, Callback(post), history=True)

    def ask(self, timeout: float, done: Asked) -> None:
        """Collect all tokens that Zenoh knows of from here on; ``done`` is called on the loop.

        Those who ask while a list is under way share the next.
        """
        self._asking.append(done)
        if not self._is_asking:
            self._ask(timeout)

    def end(self) -> None:
        """Ask no more: the session is about to close."""
        self._asking.clear()

    def _ask(self, timeout: float) -> None:
        self._is_asking = True
        asking, self._asking = self._asking, []
        listing = Listing()

        def answered() -> None:
            self._is_asking = False
            if self._asking:
                self._ask(timeout)
            for done in asking:
                done(listing)

        # Not on the thread that reads the link: it would wait for Python at every single token.
        ending = Callback(listing.add, lambda: call_on(self._loop, answered))
        self._session.liveliness().get(self._key, ending, timeout=timeout)

    def take(self, token: Token) -> None:
        """Hand on what Zenoh tells of a token, or who declared it before Zenoh does."""
        self._listed.pop(token.key, None)
        if token.is_put:
            self._there[token.key] = token
        else:
            self._there.pop(token.key, None)
        for take in list(self._followers):
            take(token)


def _token_of(sample: zenoh.Sample) -> Token:
    return Token(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT)
