"""pyzmq: a DEALER asks a ROUTER over TCP, bridged to asyncio by pyzmq itself."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
from collections.abc import AsyncIterator

from contenders.base import BareClient, Contender, Counter, Place

ONE_WAY = b""
"""The id of a message that wants no answer."""


async def serve(place: Place) -> None:
    """Give back what is asked, count what is told."""
    import zmq.asyncio  # noqa: PLC0415 -- may be missing

    counter = Counter()
    with zmq.asyncio.Context() as context:
        socket = context.socket(zmq.ROUTER)
        socket.set_hwm(0)
        socket.bind(f"tcp://127.0.0.1:{place.port}")
        while True:
            caller, id, data = await socket.recv_multipart()
            if id == ONE_WAY:
                counter.take(data)
                continue
            await socket.send_multipart([caller, id, counter.answer(data)])


class ZmqClient(BareClient):
    """Matches answers to questions by their ids."""

    def __init__(self, socket: object) -> None:
        self._socket = socket
        self._numbers = itertools.count(1)
        self._waiting: dict[bytes, asyncio.Future[bytes]] = {}

    async def listen(self) -> None:
        """Take answers for ever."""
        while True:
            id, data = await self._socket.recv_multipart()
            self._waiting.pop(id).set_result(data)

    async def ask(self, text: str) -> bytes:
        id = b"%d" % next(self._numbers)
        answer = self._waiting[id] = asyncio.get_running_loop().create_future()
        await self._socket.send_multipart([id, text.encode()])
        return await answer

    async def tell(self, text: str) -> None:
        await self._socket.send_multipart([ONE_WAY, text.encode()])


@contextlib.asynccontextmanager
async def connect(place: Place) -> AsyncIterator[ZmqClient]:
    """Connect the caller."""
    import zmq.asyncio  # noqa: PLC0415 -- may be missing

    with zmq.asyncio.Context() as context:
        socket = context.socket(zmq.DEALER)
        socket.set_hwm(0)
        socket.connect(f"tcp://127.0.0.1:{place.port}")
        client = ZmqClient(socket)
        listening = asyncio.create_task(client.listen())
        try:
            await client.ask("")
            yield client
        finally:
            listening.cancel()
            await asyncio.wait([listening])
            socket.close(linger=0)


CONTENDER = Contender("zmq", "pyzmq", serve, connect, needs=("zmq",))
