"""Bare Zenoh, bridged to asyncio as well as is known: no names, no ids, no validation.

*query* asks with Zenoh's own queries; *pub/sub* publishes question and answer on two standing
subscriptions. Through the router both sides are its clients; with direct links they are peers.
"""

from __future__ import annotations

import asyncio
import contextlib
import itertools
from collections.abc import AsyncIterator
from functools import partial
from typing import Literal

import zenoh
from zenoh.handlers import Callback

from contenders.base import START_TIMEOUT, BareClient, Contender, Counter, Place
from tca_bus import BusOptions
from tca_bus._bridge import Mailbox, ask
from tca_bus._joining import session_config
from tca_bus._wire import Payload

Links = Literal["router", "direct"]

QUERY, CALL, ANSWER, TELL = "query", "call", "answer", "tell"
BLOCK = zenoh.CongestionControl.BLOCK
MAILBOX_SIZE = 1_000_000
ENCODING = "zenoh/bytes"
READY = "ready?"


@contextlib.asynccontextmanager
async def opened(place: Place, links: Links) -> AsyncIterator[zenoh.Session]:
    """A session of a module's kind, without a module."""
    options = BusOptions(connect=place.router, links=links)
    session = await asyncio.to_thread(zenoh.open, session_config(options))
    try:
        yield session
    finally:
        await asyncio.to_thread(session.close)


class Callee:
    """Gives back what is asked in either way, counts what is told."""

    def __init__(self, session: zenoh.Session, prefix: str) -> None:
        self._counter = Counter()
        self._prefix = prefix
        self._publisher = session.declare_publisher(f"{prefix}/{ANSWER}", congestion_control=BLOCK)
        queries = Mailbox[zenoh.Query](self._reply, size=MAILBOX_SIZE)
        calls = Mailbox[zenoh.Sample](self._answer, size=MAILBOX_SIZE)
        told = Mailbox[zenoh.Sample](self._count, size=MAILBOX_SIZE)
        self._declared = [
            session.declare_queryable(f"{prefix}/{QUERY}", Callback(queries.post)),
            session.declare_subscriber(f"{prefix}/{CALL}", Callback(calls.post)),
            session.declare_subscriber(f"{prefix}/{TELL}", Callback(told.post)),
        ]

    def _reply(self, query: zenoh.Query) -> None:
        assert query.payload is not None
        with query:
            query.reply(f"{self._prefix}/{QUERY}", self._counter.answer(query.payload.to_bytes()))

    def _answer(self, sample: zenoh.Sample) -> None:
        data = self._counter.answer(sample.payload.to_bytes())
        self._publisher.put(data, attachment=sample.attachment)

    def _count(self, sample: zenoh.Sample) -> None:
        self._counter.take(sample.payload.to_bytes())


class QueryClient(BareClient):
    """Asks with Zenoh's own queries."""

    def __init__(self, session: zenoh.Session, prefix: str) -> None:
        self._session = session
        self._prefix = prefix
        self._told = session.declare_publisher(f"{prefix}/{TELL}", congestion_control=BLOCK)

    async def ask(self, text: str) -> bytes:
        payload = Payload(text.encode(), ENCODING)
        key = f"{self._prefix}/{QUERY}"
        answer = await ask(self._session, key, payload, attachment=b"", timeout=START_TIMEOUT)
        return answer.payload.data if answer is not None else b""

    async def tell(self, text: str) -> None:
        self._told.put(text.encode())


class PubSubClient(QueryClient):
    """Publishes questions and listens to answers."""

    def __init__(self, session: zenoh.Session, prefix: str) -> None:
        super().__init__(session, prefix)
        self._numbers = itertools.count(1)
        self._waiting: dict[bytes, asyncio.Future[bytes]] = {}
        self._calls = session.declare_publisher(f"{prefix}/{CALL}", congestion_control=BLOCK)
        answers = Mailbox[zenoh.Sample](self._take, size=MAILBOX_SIZE)
        self._answers = session.declare_subscriber(f"{prefix}/{ANSWER}", Callback(answers.post))

    async def ask(self, text: str) -> bytes:
        id = b"%d" % next(self._numbers)
        answer = self._waiting[id] = asyncio.get_running_loop().create_future()
        self._calls.put(text.encode(), attachment=id)
        return await answer

    def _take(self, sample: zenoh.Sample) -> None:
        assert sample.attachment is not None
        self._waiting.pop(sample.attachment.to_bytes()).set_result(sample.payload.to_bytes())


async def serve(place: Place, *, prefix: str, links: Links) -> None:
    """Run the callee."""
    async with opened(place, links) as session:
        _callee = Callee(session, prefix)
        await asyncio.get_running_loop().create_future()


@contextlib.asynccontextmanager
async def connect(
    place: Place, *, prefix: str, links: Links, kind: type[QueryClient]
) -> AsyncIterator[QueryClient]:
    """Connect the caller; ready when a query is answered."""
    async with opened(place, links) as session:
        probe = QueryClient(session, prefix)
        async with asyncio.timeout(START_TIMEOUT):
            while not await probe.ask(READY):  # noqa: ASYNC110 -- nothing says when
                await asyncio.sleep(0.05)
        yield kind(session, prefix)


def _contender(name: str, title: str, links: Links, kind: type[QueryClient]) -> Contender:
    prefix = f"bench-{name}"
    return Contender(
        name,
        title,
        partial(serve, prefix=prefix, links=links),
        partial(connect, prefix=prefix, links=links, kind=kind),
    )


CONTENDERS = [
    _contender("bare-query", "bare Zenoh query, router", "router", QueryClient),
    _contender("bare-pubsub", "bare Zenoh pub/sub, router", "router", PubSubClient),
    _contender("bare-query-direct", "bare Zenoh query, direct", "direct", QueryClient),
    _contender("bare-pubsub-direct", "bare Zenoh pub/sub, direct", "direct", PubSubClient),
]
