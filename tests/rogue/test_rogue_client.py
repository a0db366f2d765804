"""Asking an agent that is away for a moment."""

from __future__ import annotations

import asyncio

import pytest

from rogue.absence import persist
from rogue.cli._client import CENTRAL, ask
from rogue.messages import DeliveryRequest, ListRequests
from tca_bus import BusOptions, Context, Module, NoHandlerError, PeerLostError
from tca_bus.testing import bus, central, eventually

pytestmark = pytest.mark.bus


def agent(options: BusOptions) -> Module:
    module = Module("rogue", options=options)

    async def listed(message: ListRequests, context: Context) -> list[DeliveryRequest]:
        del message, context
        return []

    module.serve(ListRequests, listed)
    return module


async def test_where_an_office_is_the_agent_is_waited_for():
    async with bus() as options, central(options), Module("rogue-1", options=options) as module:
        await eventually(lambda: CENTRAL in module.available(), what="central to be seen")
        asked = asyncio.create_task(ask(module, ListRequests()))
        with pytest.raises(NoHandlerError):
            await module.query(ListRequests())
        async with agent(options):
            assert await asked == []


async def test_where_no_office_is_nobody_is_waited_for():
    async with bus() as options, Module("rogue-1", options=options) as module:
        with pytest.raises(NoHandlerError):
            await ask(module, ListRequests())


async def test_one_that_was_there_is_called_again_though_nobody_handles_it_now():
    errors = [PeerLostError("rogue", "rogueRequests"), NoHandlerError("rogueRequests")]

    async def call() -> str:
        if errors:
            raise errors.pop(0)
        return "answer"

    assert await persist(call) == "answer"
    errors.append(NoHandlerError("rogueRequests"))
    with pytest.raises(NoHandlerError):
        await persist(call)
    errors.append(NoHandlerError("rogueRequests"))
    assert await persist(call, was_there=True) == "answer"
