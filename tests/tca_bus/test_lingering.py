"""Links whose packets are lost are closed at once, and what others do with sockets is theirs."""

from __future__ import annotations

import socket
import struct
from pathlib import Path

import pytest

from tca_bus import BusOptions, Module, Router
from tca_bus.testing import FREE_PORT, eventually

pytestmark = pytest.mark.bus


def lingering():
    """The files of this process that are TCP connections whose closing waits."""
    found = []
    for file in (int(path.name) for path in Path("/dev/fd").iterdir()):
        try:
            borrowed = socket.socket(fileno=file)
        except OSError:
            continue
        try:
            borrowed.getpeername()
            waits, _ = struct.unpack(
                "ii", borrowed.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, 8)
            )
            if waits:
                found.append(file)
        except OSError:
            pass
        finally:
            borrowed.detach()
    return found


@pytest.mark.parametrize("links", ["router", "direct"])
async def test_no_link_of_a_router_or_of_its_modules_waits_when_it_is_closed(links):
    async with Router(FREE_PORT) as router:
        options = BusOptions(connect=router.endpoint, realm="prompt", links=links)
        async with Module("first", options=options), Module("second", options=options):
            await eventually(lambda: not lingering())


async def test_of_linked_routers_neither_end_waits():
    async with Router(FREE_PORT) as near, Router(FREE_PORT, links=[near.endpoint]) as far:
        await eventually(lambda: near.peers() and far.peers())
        await eventually(lambda: not lingering())


async def test_a_socket_that_somebody_else_lets_linger_does_so():
    with socket.create_server(("127.0.0.1", 0)) as server, socket.socket() as own:
        own.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 3))
        own.connect(server.getsockname())
        async with Router(FREE_PORT) as router:
            options = BusOptions(connect=router.endpoint, realm="prompt")
            async with Module("only", options=options):
                await eventually(lambda: lingering() == [own.fileno()])
