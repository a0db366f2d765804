"""The processes of a run: started together, stopped together."""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import sys
from collections.abc import AsyncIterator
from pathlib import Path

from contenders.base import Client, Contender, Place
from tca_bus import Router

MAIN = str(Path(__file__).parents[1] / "bus.py")
STOP_TIMEOUT = 10.0


async def route(endpoint: str) -> None:
    """Be the Zenoh router."""
    async with Router(endpoint):
        await asyncio.get_running_loop().create_future()


@contextlib.asynccontextmanager
async def process(*command: str, without: str = "") -> AsyncIterator[None]:
    """Run a process, ``without`` a variable of the environment; it is stopped at the end."""
    env = {name: value for name, value in os.environ.items() if name != without}
    child = await asyncio.create_subprocess_exec(*command, env=env)
    try:
        yield
    finally:
        if child.returncode is None:
            child.terminate()
        try:
            await asyncio.wait_for(child.wait(), STOP_TIMEOUT)
        except TimeoutError:
            child.kill()
            await child.wait()


@contextlib.asynccontextmanager
async def everything(
    contenders: list[Contender], data: Path
) -> AsyncIterator[dict[Contender, Client]]:
    """Start the router, the callees and what they need; give the connected callers."""
    router = f"tcp/127.0.0.1:{free_port()}"
    async with contextlib.AsyncExitStack() as stack:
        routing = process(sys.executable, MAIN, "--route", router, without="ZENOH_RUNTIME")
        await stack.enter_async_context(routing)
        await _listening(router)
        clients: dict[Contender, Client] = {}
        for contender in contenders:
            place = Place(router, free_port(), data)
            if contender.helper is not None:
                await stack.enter_async_context(process(*contender.helper(place)))
            serve = ["--serve", contender.name, place.router, str(place.port), str(place.data)]
            await stack.enter_async_context(process(sys.executable, MAIN, *serve))
            clients[contender] = await stack.enter_async_context(contender.connect(place))
        yield clients


async def _listening(endpoint: str) -> None:
    host, _, port = endpoint.removeprefix("tcp/").partition(":")
    while True:
        with contextlib.suppress(OSError):
            _, writer = await asyncio.open_connection(host, int(port))
            writer.close()
            return
        await asyncio.sleep(0.05)


def free_port() -> int:
    """A TCP port on which nothing listens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port
