"""Modules that share an arm and a lift, for the tests of resources."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager

from tca_bus import Command, Goal, Inform, Module, Query, TcaError
from tca_bus._resource_messages import ListResources
from tca_bus.testing import bus, central, eventually


class Grasp(Command[str]):
    """Ends when the gate of the arm opens."""


class Wave(Command[str]):
    """As `Grasp`."""


class Nested(Command[str]):
    """Awaits one of itself below it."""

    depth: int


class Touch(Query[int]):
    """How many are in the arm."""


class Nudge(Inform):
    """Enters the arm."""


class Trip(Goal[None]):
    """Keeps a thing until all below it has ended."""

    thing: str


@asynccontextmanager
async def pair(*, data=None):
    """A bus with central and two modules."""
    async with (
        bus() as options,
        central(options, data=data),
        Module("one", options=options) as one,
        Module("two", options=options) as two,
    ):
        await one.wait_for("tca.acquire", timeout=10.0)
        await two.wait_for("tca.acquire", timeout=10.0)
        yield one, two


async def resource(module, name):
    listed = await module.query(ListResources())
    return next((status for status in listed if status.name == name), None)


async def holders(module, name):
    status = await resource(module, name)
    return [user.module for user in status.holders] if status else []


async def waiters(module, name):
    status = await resource(module, name)
    return [user.module for user in status.waiters] if status else []


async def asked(module, name):
    try:
        return await resource(module, name)
    except TcaError:  # central is not there yet
        return None


def waiting(module, *names, **options):
    """Ask in a task of its own."""

    async def take():
        return await module.acquire(*names, **options)

    return asyncio.ensure_future(take())


class Arm:
    """A module whose handlers share an arm."""

    def __init__(self, options, *, name="robot", capacity=1, pending=None):
        self.module = module = Module(name, options=options)
        self.open = asyncio.Event()
        self.inside = 0
        self.most = 0
        self.nudged = 0
        module.resource("arm", capacity=capacity, pending=pending)
        module.serve(Grasp, self.use, resource="arm")
        module.serve(Wave, self.use, resource="arm")
        module.serve(Touch, self.touch, resource="arm")
        module.serve(Nudge, self.nudge, resource="arm")
        module.serve(Nested, self.nested)
        module.serve(Trip, self.trip)

    @property
    def in_line(self):
        """How many queries and informs wait for a place in the arm."""
        return len(self.module._handlers.resources._shared("arm")._waiters or ())

    async def use(self, _message, _context):
        self.inside += 1
        self.most = max(self.most, self.inside)
        try:
            await self.open.wait()
        finally:
            self.inside -= 1
        return "done"

    async def touch(self, _message, _context):
        return self.inside

    async def nudge(self, _message, _context):
        self.nudged += 1

    async def nested(self, message, context):
        if message.depth:
            below = await context.execute(Nested(depth=message.depth - 1))
            return await below.result()
        return "bottom"

    async def trip(self, message, context):
        await context.acquire(message.thing)
        await context.execute(Grasp())


@asynccontextmanager
async def armed(**facts):
    async with pair() as (one, two):
        arm = Arm(one.options, **facts)
        async with arm.module:
            await eventually(lambda: resource(one, "robot/arm"))
            for module in (one, two):
                await module.wait_for(Touch, Nudge, timeout=10.0)
            yield one, two, arm
            arm.open.set()
