"""A bus over two network namespaces, whose link is cut for ten seconds and healed."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from links_namespaces import NEAR_ADDRESS, NoNamespacesError, cable

from tca_bus.testing import eventually

pytestmark = [pytest.mark.bus, pytest.mark.process, pytest.mark.timeout(180)]

CREW = str(Path(__file__).with_name("links_crew.py"))
HERE = "tcp/127.0.0.1:7447"
CUT_SECONDS = 10.0
PATIENCE = 40.0


@pytest.fixture
def link():
    try:
        with cable() as made:
            yield made
    except NoNamespacesError as error:
        pytest.skip(f"network namespaces cannot be made here: {error}")


class Office:
    """Processes on both sides, and what they noted."""

    def __init__(self, link, folder):
        self.link = link
        self.folder = folder
        self._running = []

    async def spawn(self, side, *command):
        env = {**os.environ, "TCA_CONNECT": HERE, "TCA_REALM": "links"}
        argv = self.link.inside(side, sys.executable, *command)
        process = await asyncio.create_subprocess_exec(*argv, env=env)
        self._running.append(process)
        return process

    async def router(self, side, *flags):
        everywhere = ("--connect", "tcp/0.0.0.0:7447")
        return await self.spawn(side, "-m", "tca_bus", "router", *everywhere, *flags)

    async def crew(self, side, role, *more):
        return await self.spawn(side, CREW, role, str(self.folder), *more)

    def deeds(self, what, **facts):
        path = self.folder / "deeds"
        lines = path.read_text().splitlines() if path.exists() else []
        entries = [json.loads(line) for line in lines]
        return [e for e in entries if e["what"] == what and facts.items() <= e.items()]

    async def until(self, what, *, count=1, timeout=PATIENCE, **facts):
        """Wait for something to be noted; gives the last entry."""
        await eventually(
            lambda: len(self.deeds(what, **facts)) >= count, timeout=timeout, what=f"{what} {facts}"
        )
        return self.deeds(what, **facts)[-1]

    async def end(self):
        for process in self._running:
            if process.returncode is None:
                process.kill()
        for process in self._running:
            await process.wait()


@asynccontextmanager
async def office(link, folder, *, lost_after):
    """Router, central and boss near; a linked router and a lifter far."""
    running = Office(link, folder)
    try:
        await running.router("near")
        await running.router("far", "--link", f"tcp/{NEAR_ADDRESS}:7447")
        await running.crew("near", "boss")
        await running.crew("far", "lifter")
        await running.until("appeared", who="boss", module="lifter")
        flags = ("--data", str(folder), "--lost-after", str(lost_after))
        await running.spawn("near", "-m", "tca_bus", "central", *flags)
        await running.until("appeared", who="lifter", module="central")
        yield running
    finally:
        await running.end()


async def test_nothing_is_lost_when_the_link_is_cut_for_ten_seconds(link, tmp_path):
    async with office(link, tmp_path, lost_after=60) as it:
        await it.crew("near", "chief", "once")
        await it.until("begun", who="lifter")
        link.cut()
        await it.until("lost", who="boss", module="lifter")
        (tmp_path / "up").touch()
        await it.until("done", who="lifter")
        await asyncio.sleep(CUT_SECONDS)
        link.heal()
        ended = await it.until("ended", who="chief")
        assert (ended["state"], ended["result"]) == ("achieved", ["lifter", "lifter"])
        begun = it.deeds("begun")
        assert len(begun) == len({entry["task"] for entry in begun}) == 2
        assert {entry["attempt"] for entry in begun} == {1}
        await it.until("appeared", count=2, who="boss", module="lifter")
        await it.until("appeared", count=2, who="lifter", module="central")


async def test_a_module_that_was_given_up_stops_when_the_link_is_healed(link, tmp_path):
    async with office(link, tmp_path, lost_after=1) as it:
        await it.crew("near", "chief", "once")
        await it.until("begun", who="lifter")
        link.cut()
        ended = await it.until("ended", who="chief")
        assert (ended["state"], ended["result"][-1]) == ("failed", "module_lost")
        assert it.deeds("stopped") == []
        link.heal()
        await it.until("stopped", who="lifter", attempt=1)
        (tmp_path / "up").touch()
        await it.crew("near", "chief", "once")
        await it.until("ended", count=2, who="chief")
        assert it.deeds("ended")[-1]["state"] == "achieved"


async def test_what_another_module_did_meanwhile_is_not_done_twice(link, tmp_path):
    async with office(link, tmp_path, lost_after=1) as it:
        await it.crew("near", "chief", "again")
        first = await it.until("begun", who="lifter")
        link.cut()
        await it.crew("near", "spare")
        await it.until("begun", who="spare", task=first["task"], attempt=2)
        link.heal()
        await it.until("stopped", who="lifter", task=first["task"], attempt=1)
        (tmp_path / "up").touch()
        ended = await it.until("ended", who="chief")
        assert ended["state"] == "achieved"
        assert ended["result"][0] == "spare"
        done = [entry["task"] for entry in it.deeds("done")]
        assert len(done) == len(set(done)) == 2
