"""The launcher with a real router and modules on it."""

from __future__ import annotations

import os
import signal
import sys

import pytest

from tca_bus import BusOptions, Module
from tca_bus.launcher import (
    Launcher,
    ModulePresent,
    ProcessSpec,
    RestartPolicy,
    RouterListening,
    StartFailedError,
    free_port,
)
from tca_bus.testing import eventually

pytestmark = [pytest.mark.bus, pytest.mark.process]

ROUTER = """
import asyncio, os
from tca_bus import Router

async def main():
    async with Router(os.environ["TCA_CONNECT"]):
        await asyncio.get_running_loop().create_future()

asyncio.run(main())
"""

MODULE = """
import asyncio, os, sys
from tca_bus import BusOptions, Module

async def main():
    options = BusOptions(connect=os.environ["TCA_CONNECT"], realm=os.environ["TCA_REALM"])
    async with Module(sys.argv[1], options=options) as module:
        await module.serve_forever()

asyncio.run(main())
"""

HASTY = RestartPolicy(first_delay=0.01)


@pytest.fixture
def options():
    return BusOptions(connect=f"tcp/127.0.0.1:{free_port()}", realm="launched")


def router(options):
    argv = [sys.executable, "-c", ROUTER]
    return ProcessSpec("router", argv, ready=RouterListening(options), restart=HASTY)


def module(name, options, **settings):
    argv = [sys.executable, "-c", MODULE, name]
    ready = ModulePresent(name, options)
    return ProcessSpec(name, argv, ready=ready, restart=HASTY, **settings)


async def test_an_office_is_ready_when_all_its_modules_are_present(options):
    specs = [
        router(options),
        module("one", options, after=["router"]),
        module("two", options, after=["router"]),
    ]
    async with Launcher(specs, options) as office, Module("looker", options=options) as looker:
        expected = {"one": office.pid("one"), "two": office.pid("two")}
        await eventually(
            lambda: {one.name: one.pid for one in looker.modules()}.items() >= expected.items(),
            what="both modules in the table of a third",
        )


async def test_a_module_killed_by_force_is_present_again(options):
    specs = [router(options), module("one", options)]
    async with Launcher(specs, options) as office, Module("looker", options=options) as looker:
        os.kill(office.pid("one"), signal.SIGKILL)
        await office.wait_restarted("one", beyond=0)
        await eventually(
            lambda: (
                [one.pid for one in looker.modules() if one.name == "one"] == [office.pid("one")]
            ),
            what="the restarted module alone on the bus",
        )


async def test_a_router_killed_by_force_is_joined_again(options):
    specs = [router(options), module("one", options)]
    async with Launcher(specs, options) as office:
        before = office.pid("one")
        os.kill(office.pid("router"), signal.SIGKILL)
        await office.wait_restarted("router", beyond=0)
        async with Module("looker", options=options) as looker:
            await eventually(lambda: "one" in {one.name for one in looker.modules()})
        assert office.pid("one") == before


async def test_a_namesake_does_not_count_as_ready(options):
    namesake = module("one", options)
    silent = ProcessSpec(
        "silent",
        [sys.executable, "-c", "import time; time.sleep(600)"],
        ready=ModulePresent("one", options),
        ready_timeout=0.5,
    )
    with pytest.raises(StartFailedError, match="silent did not start"):
        await Launcher([router(options), namesake, silent], options).__aenter__()
