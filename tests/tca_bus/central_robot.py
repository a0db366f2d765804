"""A robot to be killed: ``python central_robot.py ENDPOINT REALM [NAME]``."""

from __future__ import annotations

import asyncio
import os
import sys
from contextlib import asynccontextmanager

from pydantic import BaseModel

from tca_bus import BusOptions, Command, Goal, Inform, Module, Query, TaskError
from tca_bus.testing import bus, central


class Place(BaseModel):
    pid: int
    attempt: int


class Drive(Command[Place]):
    """Drive until told to arrive; lost with its module."""

    to: str


class Redrive(Command[Place]):
    """Drive until told to arrive; given to the next module if this one is lost."""

    on_module_lost = "resend"

    to: str


class Deliver(Goal[str]):
    """Drive there and back."""

    there: str
    back: str


class Quick(Command[int]):
    """Done at once; fails for a number below zero."""

    number: int


class Where(Query[str]):
    """The last place it drove to."""


class Ring(Inform):
    """Ring a bell."""

    times: int


class Arrive(Inform):
    """Ends all drives."""


def robot(name: str, options: BusOptions) -> Module:
    module = Module(name, options=options)
    arrivals = asyncio.Event()
    places = ["home"]

    async def drive(message, context):
        places.append(message.to)
        await arrivals.wait()
        return Place(pid=os.getpid(), attempt=context.attempt)

    @module.handler(Deliver)
    async def deliver(message, context):
        await context.execute(Drive(to=message.there))
        await context.execute(Drive(to=message.back))
        return f"{message.there} and {message.back}"

    @module.handler(Quick, capacity=8)
    async def quick(message, context):
        if message.number < 0:
            raise TaskError("negative", f"{message.number} is below zero", data={"by": 1})
        return message.number

    @module.handler(Where)
    async def where(message, context):
        return places[-1]

    @module.handler(Ring)
    async def ring(message, context):
        places.append(f"rang {message.times}")

    @module.handler(Arrive)
    async def arrive(message, context):
        arrivals.set()

    module.serve(Drive, drive)
    module.serve(Redrive, drive)
    return module


@asynccontextmanager
async def office():
    """A bus with central, a robot and a module that sends."""
    async with (
        bus() as options,
        central(options),
        robot("robot", options),
        Module("me", options=options) as me,
    ):
        await me.wait_for("quick", "tca.submit", timeout=10.0)
        yield me


async def main(endpoint: str, realm: str, name: str = "robot") -> None:
    async with robot(name, BusOptions(connect=endpoint, realm=realm)) as module:
        await module.serve_forever()


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
