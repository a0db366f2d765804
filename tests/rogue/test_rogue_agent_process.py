"""The agent's process on a real bus, with a navigator that knows some rooms."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from navigate.messages import RoomLocation, Rooms
from rogue.messages import PostRequest, ShowRequest
from tca_bus import BusOptions, Context, HandlerFailedError, Module
from tca_bus.testing import bus, eventually

pytestmark = [pytest.mark.bus, pytest.mark.process]

ROOMS = [RoomLocation(room=f"r-53{n:02d}", x=0.0, y=180.0 * n) for n in range(1, 16)]

DIRECTORY = """\
services: {shop: r-5301}
people: {}
items:
  parcel: {phrase: parcel, rank: 1, from: shop, to: user}
"""


@asynccontextmanager
async def agent(options: BusOptions, *flags: str) -> AsyncIterator[int]:
    environment = {**os.environ, "TCA_CONNECT": options.connect, "TCA_REALM": options.realm}
    process = await asyncio.create_subprocess_exec(
        sys.executable, "-m", "rogue", "agent", *flags, env=environment
    )
    try:
        yield process.pid
    finally:
        process.terminate()
        assert await process.wait() == 0


@asynccontextmanager
async def user(options: BusOptions) -> AsyncIterator[Module]:
    """A user, and the navigator."""
    module = Module("user", options=options)

    async def rooms(message: Rooms, context: Context) -> list[RoomLocation]:
        del message, context
        return ROOMS

    module.serve(Rooms, rooms)
    async with module:
        await module.wait_for(PostRequest, timeout=40.0)
        yield module


async def test_people_come_from_a_finger_server_and_from_a_directory_read_again(tmp_path: Path):
    async def finger(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        login = (await reader.readline()).decode().strip()
        writer.write(f"Login: {login}\r\nPlan:\r\nRoom: 5307\r\n".encode())
        writer.close()

    directory = tmp_path / "people.yaml"
    directory.write_text(DIRECTORY)
    async with bus() as options, await asyncio.start_server(finger, "127.0.0.1", 0) as server:
        port = server.sockets[0].getsockname()[1]
        flags = ("--data", str(tmp_path), "--directory", str(directory))
        async with (
            agent(options, *flags, "--finger", f"127.0.0.1:{port}") as pid,
            user(options) as module,
        ):
            posted = await module.query(PostRequest(id="a", user="tom", item="parcel"))
            assert (posted.pickup, posted.deliver, posted.rank) == ("r-5301", "r-5307", 1)
            shown = await module.query(ShowRequest(id="a"))
            assert [one.source for one in shown.filled] == ["directory", "finger", "default"]
            book = PostRequest(id="b", user="tom", item="book", pickup="5303")
            with pytest.raises(HandlerFailedError, match="no item 'book'"):
                await module.query(book)
            directory.write_text(DIRECTORY + "  book: {phrase: book, rank: 2, to: user}\n")
            os.kill(pid, signal.SIGHUP)

            async def is_known() -> bool:
                try:
                    return (await module.query(book)).rank == 2
                except HandlerFailedError:
                    return False

            await eventually(is_known, what="the directory to be read again")
