"""A process that holds things until it is killed: ``resource_holder.py ENDPOINT REALM NAME...``."""

from __future__ import annotations

import asyncio
import sys

from tca_bus import BusOptions, Command, Module


class Ride(Command[None]):
    """Holds a thing for as long as it runs, which is until it is killed."""

    thing: str


async def main(endpoint: str, realm: str, *names: str) -> None:
    module = Module("holder", options=BusOptions(connect=endpoint, realm=realm))

    @module.handler(Ride)
    async def ride(message, context):
        async with context.acquire(message.thing):
            await asyncio.get_running_loop().create_future()

    async with module:
        if not names:
            await module.serve_forever()
        async with module.acquire(*names):
            await module.serve_forever()


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
