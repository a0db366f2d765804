"""nats-py with nats-server: requests over the shared inbox, and plain publishing."""

from __future__ import annotations

import asyncio
import contextlib
import shutil
import sys
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

from contenders.base import START_TIMEOUT, BareClient, Contender, Counter, Place

SERVER = "nats-server"
ASK = "bench.ask"
TELL = "bench.tell"
NO_LIMIT = -1


def server_program() -> str | None:
    """The server, beside this Python or on the path."""
    beside = Path(sys.executable).with_name(SERVER)
    return str(beside) if beside.exists() else shutil.which(SERVER)


def why_not() -> str | None:
    """What is missing."""
    return None if server_program() else f"no {SERVER} here: uv sync --group bench"


def command(place: Place) -> list[str]:
    """The command line of the server."""
    return [server_program() or SERVER, "-a", "127.0.0.1", "-p", str(place.port), "-l", "/dev/null"]


async def _join(place: Place) -> Any:
    import nats  # noqa: PLC0415 -- may be missing

    # The first tries come before the server listens.
    tries = int(START_TIMEOUT / 0.1)
    return await nats.connect(
        f"nats://127.0.0.1:{place.port}",
        max_reconnect_attempts=tries,
        reconnect_time_wait=0.1,
        error_cb=_quiet,
        pending_size=64 * 1024 * 1024,
    )


async def _quiet(_: Exception) -> None:
    """Say nothing of tries that come too early."""


async def serve(place: Place) -> None:
    """Give back what is asked, count what is told."""
    counter = Counter()
    client = await _join(place)

    async def ask(message: Any) -> None:
        await message.respond(counter.answer(message.data))

    async def tell(message: Any) -> None:
        counter.take(message.data)

    await client.subscribe(ASK, cb=ask)
    limits = {"pending_msgs_limit": NO_LIMIT, "pending_bytes_limit": NO_LIMIT}
    await client.subscribe(TELL, cb=tell, **limits)
    await client.flush()
    await asyncio.get_running_loop().create_future()


class NatsClient(BareClient):
    """One connection."""

    def __init__(self, client: Any) -> None:
        self._client = client

    async def ask(self, text: str) -> bytes:
        answer = await self._client.request(ASK, text.encode(), timeout=START_TIMEOUT)
        return answer.data  # type: ignore[no-any-return]

    async def tell(self, text: str) -> None:
        await self._client.publish(TELL, text.encode())


@contextlib.asynccontextmanager
async def connect(place: Place) -> AsyncIterator[NatsClient]:
    """Connect the caller, and wait until the callee answers."""
    from nats.errors import NoRespondersError  # noqa: PLC0415 -- may be missing

    client = await _join(place)
    try:
        async with asyncio.timeout(START_TIMEOUT):
            while True:
                with contextlib.suppress(NoRespondersError):
                    await client.request(ASK, b"", timeout=START_TIMEOUT)
                    break
                await asyncio.sleep(0.05)
        yield NatsClient(client)
    finally:
        await client.close()


CONTENDER = Contender(
    "nats", "NATS", serve, connect, needs=("nats",), helper=command, why_not=why_not
)
