"""A bounded stream of what arrives."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Generic, Self, TypeVar

from tca_bus._errors import ClosedError

M = TypeVar("M")

Opener = Callable[["Subscription[M]"], Awaitable[Callable[[], None]]]
"""Connects a subscription to its source; gives the function that disconnects it."""


class Subscription(Generic[M]):
    """Messages as they come, in order: an async context manager and an async iterator.

    Holds at most ``size`` messages; when full the oldest is dropped and ``dropped`` counts it.
    Messages that arrive before it is entered or while the router is away are not seen. The
    iterator ends when the subscription is closed.
    """

    def __init__(self, name: str, opener: Opener[M], *, size: int) -> None:
        self.name = name
        self.dropped = 0
        self._opener = opener
        self._size = size
        self._items: deque[M] = deque()
        self._bell = asyncio.Event()
        self._disconnect: Callable[[], None] | None = None
        self._closed = False

    @property
    def waiting(self) -> int:
        """How many messages wait to be taken."""
        return len(self._items)

    async def __aenter__(self) -> Self:
        """Begin to receive: what is sent after this has returned is seen."""
        if self._closed or self._disconnect is not None:
            raise ClosedError(f"subscription to {self.name}")
        self._disconnect = await self._opener(self)
        return self

    async def __aexit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Stop receiving; a waiting iterator ends."""
        self._closed = True
        self._bell.set()
        if self._disconnect is not None:
            self._disconnect()
            self._disconnect = None

    def push(self, item: M) -> None:
        """Append an item, dropping the oldest when full."""
        if len(self._items) >= self._size:
            self._items.popleft()
            self.dropped += 1
        self._items.append(item)
        self._bell.set()

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> M:
        while not self._items:
            if self._closed:
                raise StopAsyncIteration
            self._bell.clear()
            await self._bell.wait()
        return self._items.popleft()

    def at_hand(self) -> M | None:
        """The next message if one is there; None is no end."""
        return self._items.popleft() if self._items else None

    async def get(self) -> M:
        """The next message.

        Raises:
            ClosedError: The subscription is closed.
        """
        try:
            return await anext(self)
        except StopAsyncIteration:
            raise ClosedError(f"subscription to {self.name}") from None
