"""The robot of ``docs/own-robot.md`` is driven by the real navigator, as it stands on the page."""

from __future__ import annotations

import asyncio
import math
import os
import re
import sys
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from navigate.maps import load_plan
from navigate.messages import NavigateToGoal, WhereIsRoom
from tca_bus import Module
from tca_bus.testing import bus, central
from xavier_sim.messages import Drive, Sensors

TEXT = (Path(__file__).parents[2] / "docs" / "own-robot.md").read_text(encoding="utf-8")
PROGRAM = re.search(r"```python\n(.*?)```", TEXT, re.DOTALL)[1]
FLOOR = re.search(r"```yaml flat.yaml\n(.*?)```", TEXT, re.DOTALL)[1]
WITHOUT_US = "import sys; sys.modules['xavier_sim'] = None; exec(sys.argv.pop(1))"
SPEED = "8"


@asynccontextmanager
async def process(*arguments, **variables):
    running = await asyncio.create_subprocess_exec(
        sys.executable,
        *arguments,
        env={**os.environ, **variables},
        stderr=asyncio.subprocess.PIPE,
    )
    try:
        yield running
    finally:
        if running.returncode is None:
            running.terminate()
        await running.communicate()


@pytest.mark.bus
@pytest.mark.process
async def test_the_navigator_drives_the_robot_of_the_page(tmp_path):
    (tmp_path / "flat.yaml").write_text(FLOOR)
    plan = load_plan(tmp_path / "flat.yaml")
    async with bus() as options, central(options):
        at = {"TCA_CONNECT": options.connect, "TCA_REALM": options.realm}
        own = ("-c", WITHOUT_US, PROGRAM, options.connect, options.realm, SPEED)
        run = ("-m", "navigate", "run", "--map", str(tmp_path / "flat.yaml"))
        async with (
            process(*own) as robot,
            process(*run, **at),
            Module("asker", options=options) as asker,
            asker.subscribe(Sensors) as sensed,
        ):
            await asker.wait_for(NavigateToGoal, Drive, timeout=30)
            goal = await asker.query(WhereIsRoom(room="r-1"))
            drive = await asker.expand(NavigateToGoal(x=goal.x, y=goal.y), wait_for_handler=20)
            report = await drive.result(timeout=40)
            async with asyncio.timeout(10):
                async for last in sensed:
                    if last.time > report.position.time and last.speed == 0.0:
                        break
            assert robot.returncode is None
    assert report.position.room == "r-1"
    place = plan.places["r-1"]
    truth = (plan.start.x + last.odom[0], plan.start.y + last.odom[1])
    assert math.dist(truth, (place.x, place.y)) < 0.25


def test_the_robot_of_the_page_knows_the_bus_only():
    assert set(re.findall(r"^(?:from|import) (\w+)", PROGRAM, re.MULTILINE)) == {
        "asyncio",
        "numpy",
        "sys",
        "tca_bus",
    }
