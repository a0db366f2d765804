"""Fixtures of the tests of the task tree over the bus."""

from __future__ import annotations

from collections.abc import AsyncIterator

import pytest
from tree_robot import Fetch, Robot, Step

from tca_bus import BusOptions, Module
from tca_bus.testing import bus, central


@pytest.fixture
async def options() -> AsyncIterator[BusOptions]:
    async with bus() as options, central(options):
        yield options


@pytest.fixture
async def robot(options: BusOptions) -> AsyncIterator[Robot]:
    module = Module("robot", options=options)
    robot = Robot(module)
    robot.serve()
    async with module:
        yield robot


@pytest.fixture
async def user(options: BusOptions, robot: Robot) -> AsyncIterator[Module]:
    async with Module("user", options=options) as module:
        await module.wait_for(Step, Fetch, timeout=10.0)
        yield module
