"""A module whose handler blocks its event loop: ``python bus_blocker.py ENDPOINT REALM``."""

from __future__ import annotations

import asyncio
import sys
import time

from tca_bus import BusOptions, Module, Query, configure_logging


class Ask(Query[int]):
    number: int = 0


class Block(Query[None]):
    wire_name = "block"

    seconds: float


def spin(seconds: float) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        pass


async def main(endpoint: str, realm: str) -> None:
    configure_logging("blocker", level="info", json=False)
    module = Module("blocker", options=BusOptions(connect=endpoint, realm=realm))

    @module.handler(Block)
    async def block(message, context):
        spin(message.seconds)

    @module.handler(Ask)
    async def ask(message, context):
        return message.number

    async with module:
        await module.serve_forever()


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
