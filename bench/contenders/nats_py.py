"""nats-py with nats-server: requests over the shared inbox, and plain publishing.

Once with bytes as they are, and once with the models that our bus carries: built, written as JSON,
read and validated at both ends, as an application would that wants the same of its messages.
"""

from __future__ import annotations

import asyncio
import contextlib
import shutil
import sys
from collections.abc import AsyncIterator
from functools import partial
from pathlib import Path
from typing import Any

from pydantic import BaseModel

from contenders.base import START_TIMEOUT, BareClient, Contender, Counter, Place

SERVER = "nats-server"
ASK, TELL = "ask", "tell"
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


class Echo(BaseModel):
    """What our bus carries, too."""

    text: str


def write(text: str) -> bytes:
    """A text as a validated model, in JSON."""
    return Echo(text=text).model_dump_json().encode()


def read(data: bytes) -> str:
    """The text of a validated model."""
    return Echo.model_validate_json(data).text


async def serve(place: Place, *, prefix: str, with_models: bool) -> None:
    """Give back what is asked, count what is told."""
    counter = Counter()
    client = await _join(place)

    async def ask(message: Any) -> None:
        await message.respond(counter.answer(message.data))

    async def ask_model(message: Any) -> None:
        answer = counter.answer(read(message.data).encode())
        await message.respond(write(answer.decode()))

    async def tell(message: Any) -> None:
        counter.take(read(message.data) if with_models else message.data)

    await client.subscribe(f"{prefix}.{ASK}", cb=ask_model if with_models else ask)
    limits = {"pending_msgs_limit": NO_LIMIT, "pending_bytes_limit": NO_LIMIT}
    await client.subscribe(f"{prefix}.{TELL}", cb=tell, **limits)
    await client.flush()
    await asyncio.get_running_loop().create_future()


class NatsClient(BareClient):
    """One connection, and bytes."""

    def __init__(self, client: Any, prefix: str) -> None:
        self._client = client
        self._ask = f"{prefix}.{ASK}"
        self._tell = f"{prefix}.{TELL}"

    async def ask(self, text: str) -> bytes:
        answer = await self._client.request(self._ask, text.encode(), timeout=START_TIMEOUT)
        return answer.data  # type: ignore[no-any-return]

    async def tell(self, text: str) -> None:
        await self._client.publish(self._tell, text.encode())


class ModelClient(NatsClient):
    """One connection, and models."""

    async def ask(self, text: str) -> bytes:
        answer = await self._client.request(self._ask, write(text), timeout=START_TIMEOUT)
        return read(answer.data).encode()

    async def tell(self, text: str) -> None:
        await self._client.publish(self._tell, write(text))


@contextlib.asynccontextmanager
async def connect(
    place: Place, *, prefix: str, kind: type[NatsClient]
) -> AsyncIterator[NatsClient]:
    """Connect the caller, and wait until the callee answers."""
    from nats.errors import NoRespondersError  # noqa: PLC0415 -- may be missing

    connection = await _join(place)
    client = kind(connection, prefix)
    try:
        async with asyncio.timeout(START_TIMEOUT):
            while True:
                with contextlib.suppress(NoRespondersError):
                    await client.ask("ready?")
                    break
                await asyncio.sleep(0.05)
        yield client
    finally:
        await connection.close()


def _contender(name: str, title: str, kind: type[NatsClient]) -> Contender:
    return Contender(
        name,
        title,
        partial(serve, prefix=name, with_models=kind is ModelClient),
        partial(connect, prefix=name, kind=kind),
        needs=("nats",),
        helper=command,
        why_not=why_not,
    )


CONTENDERS = [
    _contender("nats", "NATS", NatsClient),
    _contender("nats-models", "NATS, the same models", ModelClient),
]
