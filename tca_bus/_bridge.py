"""From Zenoh's callbacks to asyncio.

Zenoh calls back on threads of its own. A subscriber or queryable gets a persistent *indirect*
callback (one thread per declared entity) that appends to a `Mailbox`; the mailbox wakes the loop
once for any number of waiting items. Replies of a ``get`` come through a *direct* callback, which
starts no thread. Measured: 410 000 messages a second against 11 000 by ``run_in_executor(recv)``.

Threads of their own mix up what came by several declarations. Where that counts, all callbacks of a
session are direct, on the one thread that reads the link, and their mailboxes share an `Arrivals`:
dearer by some microseconds a message, and a module that keeps Python's lock for longer than the
lease of the link loses it for a moment.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections import deque
from collections.abc import Callable
from typing import Generic, NamedTuple, TypeVar

import zenoh
from zenoh.handlers import Callback

from tca_bus._wire import Payload

logger = logging.getLogger(__name__)

T = TypeVar("T")

BATCH = 128
"""Messages that a mailbox hands over before the loop, and the handlers on it, get their turn."""

LONGEST_WAIT = 1e9
"""Wall seconds; Zenoh takes no infinite timeout."""


class Arrivals:
    """Wakes the loop to hand over what is in one or more mailboxes, in the order of its coming.

    After ``batch`` messages whoever they woke gets a turn. With a batch of one a handler is as far
    as it gets without waiting when the next message is handed over, whoever that is for.
    """

    def __init__(self, batch: int = BATCH) -> None:
        self._batch = batch
        self._turns: deque[Callable[[], int]] = deque()
        self._armed = False
        self._loop = asyncio.get_running_loop()

    def announce(self, hand_over: Callable[[], int]) -> None:
        """Have ``hand_over`` called on the loop, in its turn; called on any thread.

        It says how many messages it handed over.
        """
        self._turns.append(hand_over)
        if not self._armed:
            self._armed = True
            call_on(self._loop, self._drain)

    def _drain(self) -> None:
        # Disarmed before emptying: what is announced from here on wakes the loop again.
        self._armed = False
        turns = self._turns
        left = self._batch
        while left > 0:
            if not turns:
                return
            left -= turns.popleft()()
        if not self._armed:
            self._armed = True
            self._loop.call_soon(self._drain)


class Mailbox(Generic[T]):
    """Hands items from a callback thread to a function on the loop, in order.

    ``consume`` may say how many messages an item was. Holds at most ``size`` items. When full,
    ``post`` drops the oldest and counts it in ``dropped``, or gives the new item to ``refuse`` on
    the posting thread, if there is one. Boxes that share their ``arrivals`` keep the order of
    items among them too.
    """

    def __init__(
        self,
        consume: Callable[[T], int | None],
        *,
        size: int,
        refuse: Callable[[T], None] | None = None,
        arrivals: Arrivals | None = None,
    ) -> None:
        self._consume = consume
        self._size = size
        self._refuse = refuse
        self._items: deque[T] = deque()
        self._arrivals = arrivals or Arrivals()
        self.dropped = 0

    def post(self, item: T) -> None:
        """Append an item; called on one thread at a time."""
        is_full = len(self._items) >= self._size
        if is_full:
            self.dropped += 1
            if self._refuse is not None:
                self._refuse(item)
                return
        self._items.append(item)
        if is_full:
            # Whatever is dropped leaves its turn to what comes after it: there are no more turns
            # than items, however long nobody takes them.
            self._items.popleft()
        else:
            self._arrivals.announce(self._hand_over)

    def _hand_over(self) -> int:
        try:
            return self._consume(self._items.popleft()) or 1
        except Exception:
            # An item that cannot be consumed must not hold up those behind it.
            logger.exception("an arrival was not taken")
            return 1


def call_on(loop: asyncio.AbstractEventLoop, function: Callable[[], None]) -> None:
    """Call on the loop from another thread; does nothing when the loop has ended."""
    # A closed loop has nobody left who could wait for the item.
    with contextlib.suppress(RuntimeError):
        loop.call_soon_threadsafe(function)


class Answer(NamedTuple):
    """The terminal reply of a query: its payload, and whether it is an error."""

    payload: Payload
    is_error: bool


async def ask(
    session: zenoh.Session,
    key: str,
    payload: Payload,
    *,
    attachment: bytes,
    timeout: float,
    arrivals: Arrivals | None = None,
) -> Answer | None:
    """Send one query and wait for its first reply, which comes in its turn among ``arrivals``.

    None when the query ended without a reply: nobody there, the callee died, or the router went.

    Raises:
        TimeoutError: No reply within ``timeout`` wall seconds.
    """
    future, callback = _first_reply(arrivals or Arrivals())
    token = zenoh.CancellationToken()
    session.get(
        key,
        callback,
        payload=payload.data,
        encoding=payload.encoding,
        attachment=attachment,
        consolidation=zenoh.ConsolidationMode.NONE,
        timeout=min(timeout, LONGEST_WAIT) + 1.0,
        cancellation_token=token,
    )
    try:
        async with asyncio.timeout(timeout):
            reply = await future
    finally:
        if not future.done() or future.cancelled():
            token.cancel()
    return None if reply is None else _answer_of(reply)


def _first_reply(
    arrivals: Arrivals,
) -> tuple[asyncio.Future[zenoh.Reply | None], Callback[zenoh.Reply]]:
    """A future for the first reply, None at the end of all replies, and what fulfils it."""
    loop = asyncio.get_running_loop()
    future: asyncio.Future[zenoh.Reply | None] = loop.create_future()

    def settle(reply: zenoh.Reply | None) -> int:
        if not future.done():
            future.set_result(reply)
        return 1

    def on_reply(reply: zenoh.Reply | None = None) -> None:
        arrivals.announce(lambda: settle(reply))

    return future, Callback(on_reply, on_reply, indirect=False)


def _answer_of(reply: zenoh.Reply) -> Answer:
    result = reply.result
    payload = payload_of(result)
    return Answer(payload, is_error=isinstance(result, zenoh.ReplyError))


def payload_of(received: zenoh.Sample | zenoh.ReplyError) -> Payload:
    """The payload of what arrived."""
    return Payload(received.payload.to_bytes(), str(received.encoding))


def query_payload(query: zenoh.Query) -> Payload:
    """The payload of a query that arrived; an empty JSON object when it has none."""
    if query.payload is None:
        return Payload(b"{}", "")
    return Payload(query.payload.to_bytes(), str(query.encoding or ""))


def attachment_of(received: zenoh.Sample | zenoh.Query) -> bytes | None:
    """The attachment of what arrived, if it has one."""
    attachment = received.attachment
    return None if attachment is None else attachment.to_bytes()
