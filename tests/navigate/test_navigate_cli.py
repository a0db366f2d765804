"""``navigate where`` as people type it: a drawing, a live picture, errors."""

from __future__ import annotations

import asyncio
import json
import sys
from xml.etree import ElementTree as ET

import pytest
from command_line import run_command
from navigate_office import office

from navigate.cli import app
from navigate.messages import Outlook, ShowOutlook
from xavier_sim.messages import MoveDoor, ShowWorld, WhereReally

pytestmark = [pytest.mark.bus, pytest.mark.process]


def started(*arguments):
    return asyncio.create_subprocess_exec(
        sys.executable,
        *("-m", "navigate", "where", *arguments),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )


async def ran(*arguments, command="where"):
    done = await run_command(app, command, *arguments)
    return done.code, done.out, done.err


async def first_lines(number, *arguments):
    process = await started(*arguments)
    lines = [await process.stdout.readline() for _ in range(number)]
    process.terminate()
    await process.communicate()
    return [line.decode() for line in lines]


async def test_where_draws_and_watches(tmp_path):
    drawing, live = tmp_path / "robot.svg", tmp_path / "live.svg"
    async with office() as asker:
        flags = ("--connect", asker.options.connect, "--realm", asker.options.realm)
        await asker.query(MoveDoor(room="r-5303", open=False))
        world = await asker.query(ShowWorld())
        outlook = await asker.query(ShowOutlook())
        assert world.robot == await asker.query(WhereReally())
        assert {door.room for door in world.doors if not door.open} == {"r-5303"}
        once = await ran("--svg", str(drawing), *flags)
        wrong = await ran("--svg", str(tmp_path / "none" / "robot.svg"), *flags)
        told, shown, drawn = await asyncio.gather(
            first_lines(2, "--watch", "--json", *flags),
            first_lines(40, "--watch", *flags),
            first_lines(1, "--watch", "--json", "--svg", str(live), *flags),
        )
        position = json.loads((await ran("--json", *flags, command="stop"))[1])
    assert position["x"] == outlook.belief.position.x
    assert once[0] == 0, once[2]
    assert f"drawn in {drawing}" in once[2]
    titles = [one.text for one in ET.parse(drawing).iter() if one.get("class") == "title"]
    assert titles == ["Simulator", "Navigator"]
    assert wrong[0] == 2
    assert "--svg" in wrong[2]
    states = [Outlook.model_validate_json(line) for line in told]
    assert states[0].belief.cells == outlook.belief.cells
    assert json.loads(told[0])["sonar"] == outlook.sonar
    assert "believed at" in "".join(shown)
    assert "belief" in drawn[0]
    assert live.read_text(encoding="utf-8").startswith("<svg")
