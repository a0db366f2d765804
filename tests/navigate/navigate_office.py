"""Router, central, robot and navigator in one process, for tests on a real bus."""

from __future__ import annotations

import asyncio
from contextlib import asynccontextmanager

from navigate.keeping import StateFile
from navigate.maps import Floor, load_plan
from navigate.messages import NavigateToGoal
from navigate.navigator import Navigator
from navigate.service import NavigateService
from tca_bus import Module
from tca_bus.testing import bus, central
from xavier_sim.floors import load_floor
from xavier_sim.messages import WhereReally
from xavier_sim.running import RobotModule, RobotState, SimClock
from xavier_sim.world import World


@asynccontextmanager
async def running(runner):
    async with asyncio.TaskGroup() as group:
        task = group.create_task(runner, name="service")
        try:
            yield
        finally:
            task.cancel()


@asynccontextmanager
async def office(folder=None):
    """Router, central, robot and navigator; gives the module that asks them."""
    async with bus(clock="sim") as options, central(options):
        state = RobotState(World(load_floor("wean5"), seed=1), SimClock(1000.0), speed=None)
        kept = StateFile(folder) if folder else None
        service = NavigateService(Navigator(Floor(load_plan()), seed=1), options, kept)
        async with (
            running(RobotModule(state, None, options).run()),
            running(service.run()),
            Module("asker", options=options) as asker,
        ):
            await asker.wait_for(NavigateToGoal, WhereReally, timeout=10)
            yield asker
