"""A module to be killed: ``python bus_victim.py ENDPOINT REALM [LINKS]``."""

from __future__ import annotations

import asyncio
import sys
from typing import Literal

from tca_bus import BusOptions, Command, Module, Query


class Sleep(Query[None]):
    pass


class Pid(Query[int]):
    pass


class Toil(Command[int]):
    wire_name = "toil"


class Retoil(Command[int]):
    wire_name = "retoil"
    on_module_lost = "resend"


async def main(endpoint: str, realm: str, links: Literal["router", "direct"] = "router") -> None:
    options = BusOptions(connect=endpoint, realm=realm, links=links)
    module = Module("victim", options=options)

    async def forever(message, context):
        await asyncio.Event().wait()

    for kind in (Sleep, Toil, Retoil):
        module.serve(kind, forever)
    async with module:
        await module.serve_forever()


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
