"""gRPC for asyncio: unary calls, and one call's stream for what is told one way."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator

from contenders.base import START_TIMEOUT, BareClient, Contender, Counter, Place

SERVICE = "bench.Echo"
ASK = f"/{SERVICE}/Ask"
TELL = f"/{SERVICE}/Tell"
MOST_BYTES = [("grpc.max_receive_message_length", -1)]


async def serve(place: Place) -> None:
    """Give back what is asked, count what is told."""
    import grpc.aio  # noqa: PLC0415 -- may be missing

    counter = Counter()

    async def ask(data: bytes, _: object) -> bytes:
        return counter.answer(data)

    async def tell(stream: AsyncIterator[bytes], _: object) -> bytes:
        async for data in stream:
            counter.take(data)
        return b""

    server = grpc.aio.server(options=MOST_BYTES)
    handlers = {
        "Ask": grpc.unary_unary_rpc_method_handler(ask),
        "Tell": grpc.stream_unary_rpc_method_handler(tell),
    }
    server.add_generic_rpc_handlers((grpc.method_handlers_generic_handler(SERVICE, handlers),))
    server.add_insecure_port(f"127.0.0.1:{place.port}")
    await server.start()
    await server.wait_for_termination()


class GrpcClient(BareClient):
    """One channel, and one open stream."""

    def __init__(self, channel: object) -> None:
        self._ask = channel.unary_unary(ASK)
        self._stream = channel.stream_unary(TELL)()

    async def ask(self, text: str) -> bytes:
        return await self._ask(text.encode())

    async def tell(self, text: str) -> None:
        await self._stream.write(text.encode())

    async def close(self) -> None:
        await self._stream.done_writing()
        await self._stream


@contextlib.asynccontextmanager
async def connect(place: Place) -> AsyncIterator[GrpcClient]:
    """Connect the caller."""
    import grpc.aio  # noqa: PLC0415 -- may be missing

    async with grpc.aio.insecure_channel(f"127.0.0.1:{place.port}", options=MOST_BYTES) as channel:
        await asyncio.wait_for(channel.channel_ready(), START_TIMEOUT)
        client = GrpcClient(channel)
        try:
            yield client
        finally:
            await client.close()


CONTENDER = Contender("grpc", "gRPC asyncio", serve, connect, needs=("grpc",))
