"""Linked routers make one bus, whichever is there first."""

from __future__ import annotations

import asyncio
import json
import sys
from contextlib import asynccontextmanager

import pytest

from tca_bus import BusOptions, ConfigError, Module, Query, Router
from tca_bus._joining import client_config
from tca_bus._router import router_settings
from tca_bus.cli.tca import app
from tca_bus.launcher import RouterListening
from tca_bus.testing import FREE_PORT, eventually

pytestmark = pytest.mark.bus


class Where(Query[str]):
    pass


def guide(options):
    module = Module("guide", options=options)

    @module.handler(Where)
    async def where(message, context):
        return "here"

    return module


async def test_modules_of_linked_routers_meet():
    async with Router(FREE_PORT) as near, Router(FREE_PORT, links=[near.endpoint]) as far:
        here, there = (BusOptions(connect=r.endpoint, realm="linked") for r in (near, far))
        async with guide(there), Module("asker", options=here) as asker:
            await asker.wait_for(Where, timeout=10.0)
            assert await asker.query(Where()) == "here"


@pytest.mark.process
async def test_a_router_starts_without_its_link_and_finds_it_again_and_again():
    async with Router(FREE_PORT) as first:
        near = BusOptions(connect=first.endpoint, realm="linked")
    async with Router(FREE_PORT, links=[near.connect]) as router:
        far = BusOptions(connect=router.endpoint, realm="linked")
        async with guide(far) as module:
            for _ in range(2):
                async with router_process(near), Module("asker", options=near) as asker:
                    await asker.wait_for(Where, timeout=20.0)
                    assert await asker.query(Where()) == "here"
                await eventually(lambda: [m.name for m in module.modules()] == ["guide"])


@asynccontextmanager
async def router_process(options):
    arguments = ["-m", "tca_bus", "router", "--connect", options.connect]
    process = await asyncio.create_subprocess_exec(sys.executable, *arguments)
    try:
        await RouterListening(options).wait(process.pid)
        yield
    finally:
        process.kill()
        await process.wait()


def test_a_link_that_is_no_endpoint_is_refused():
    with pytest.raises(ConfigError, match="--link"):
        Router(FREE_PORT, links=["nowhere"])


def test_a_try_to_link_that_began_during_a_cut_leaves_time_for_another_within_a_second():
    settings = router_settings("tcp/127.0.0.1:7447", links=["tcp/10.0.0.1:7447"])
    one_try = settings["transport"]["unicast"]["open_timeout"]
    pause = settings["connect"]["retry"]["period_max_ms"]
    assert one_try + pause < 700


@pytest.mark.parametrize("seconds", [0.0, -1.0, 61.0, float("nan")])
def test_a_link_timeout_that_is_of_no_use_is_refused(seconds):
    with pytest.raises(ConfigError, match="--link-timeout"):
        Router(FREE_PORT, link_timeout=seconds)


def test_slow_links_get_more_time():
    settings = router_settings("tcp/127.0.0.1:7447", link_timeout=2.5)
    assert settings["transport"]["unicast"]["open_timeout"] == 2500


@pytest.mark.parametrize(
    ("endpoint", "limit"),
    [
        ("tcp/127.0.0.1:7447", 10_000),
        ("tcp/localhost:7447", 10_000),
        ("tcp/[::1]:7447", 10_000),
        ("unixsock-stream//tmp/bus", 10_000),
        ("tcp/10.0.0.1:7447", 500),
        ("tcp/router:7447", 500),
        ("tcp/localhosts:7447", 500),
    ],
)
def test_a_module_tries_anew_when_a_network_lost_its_packets(endpoint, limit):
    config = client_config(BusOptions(connect=endpoint))
    assert json.loads(config.get_json("transport/unicast/open_timeout")) == limit


def test_links_are_flags():
    tokens = ["router", "--link", "tcp/10.0.0.1:7447", "--link", "tcp/10.0.0.2:7447"]
    _, bound, _ = app.parse_args(tokens)
    assert bound.arguments["link"] == ["tcp/10.0.0.1:7447", "tcp/10.0.0.2:7447"]
