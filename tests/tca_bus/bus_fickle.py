"""A module that listens and leaves off again and again: ``python bus_fickle.py TIMES``."""

from __future__ import annotations

import asyncio
import sys

from tca_bus import Broadcast, Module
from tca_bus.testing import bus


class Shout(Broadcast):
    number: int


async def main(times: int) -> None:
    async with bus() as options, Module("listener", options=options) as module:
        for _ in range(times):
            async with module.subscribe(Shout):
                pass


if __name__ == "__main__":
    asyncio.run(main(int(sys.argv[1])))
