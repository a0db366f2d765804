"""What shows the planner at work: ``rogue plan``, ``rogue trace``, ``rogue why``."""

from __future__ import annotations

import asyncio
import contextlib
import json
from html import unescape
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from rogue.cli._drawing import write_drawing
from rogue.cli._plan import plan
from rogue.cli._requests import why
from rogue.cli._trace import trace
from rogue.messages import (
    PlanView,
    ReadTrace,
    ShowPlan,
    TraceLine,
    Why,
    WhyEntry,
    WhyReport,
)
from rogue.prodigy import GoalTree, Standing, TreeNode, TreeStep
from tca_bus import ConfigError, Module
from tca_bus.cli import BusFlags
from tca_bus.testing import ScriptedModule, bus, eventually

GOAL = TreeNode(5, is_goal=True, name="has-item", args="jhm fax", standing=Standing.PENDING)
DONE = TreeNode(5, is_goal=True, name="has-item", args="jhm fax", standing=Standing.DONE)
STEP = TreeStep(8, "<deliver-item r-1 jhm fax>", Standing.EXECUTED)


def view(*nodes: TreeNode, steps: tuple[TreeStep, ...] = ()) -> PlanView:
    return PlanView(planning=True, nodes=[], executed=[], tree=GoalTree(nodes, steps))


def standing_in(file: Path) -> str | None:
    """How the drawing shows n5."""
    if not file.exists():
        return None
    [found] = [one for one in ET.parse(file).iter() if one.get("id") == "n5"]
    return found.get("class")


@pytest.mark.bus
async def test_a_plan_is_printed_drawn_and_given_as_data(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    async with bus() as options, ScriptedModule("rogue", options=options) as agent:
        agent.answers(ShowPlan, view(GOAL, steps=(STEP,)))
        flags = BusFlags(connect=options.connect, realm=options.realm)
        await plan(flags=flags)
        assert "n5 (has-item jhm fax) pending" in capsys.readouterr().out
        file = tmp_path / "plan.svg"
        await plan(svg=file, flags=flags)
        assert "1 goals and operators are drawn in" in capsys.readouterr().err
        assert "<deliver-item r-1 jhm fax>  executed" in unescape(file.read_text())
        await plan(flags=BusFlags(connect=options.connect, realm=options.realm, json=True))
        document = json.loads(capsys.readouterr().out)
        assert document["tree"]["nodes"][0]["standing"] == "pending"
        assert document["tree"]["steps"][0]["number"] == 8


@pytest.mark.bus
async def test_a_watched_plan_is_drawn_again_when_it_changes(tmp_path: Path):
    file = tmp_path / "plan.svg"
    async with bus() as options, ScriptedModule("rogue", options=options) as agent:
        agent.answers(ShowPlan, view(GOAL), view(DONE))
        flags = BusFlags(connect=options.connect, realm=options.realm)
        watching = asyncio.create_task(plan(svg=file, watch=True, flags=flags))
        try:
            await eventually(lambda: standing_in(file) == "pending", what="a drawing")
            async with Module("crier", options=options) as crier:
                await crier.broadcast(TraceLine(seq=1, time=1.0, text="a step"))
                await eventually(lambda: standing_in(file) == "done", what="the new drawing")
        finally:
            watching.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await watching


def test_a_drawing_that_cannot_be_written_says_so(tmp_path: Path):
    with pytest.raises(ConfigError, match="a file that can be written"):
        write_drawing(tmp_path / "none" / "plan.svg", GoalTree(), title="x")


def test_a_view_of_the_plan_crosses_the_bus_whole():
    one = view(GOAL, DONE, steps=(STEP,))
    assert PlanView.model_validate_json(one.model_dump_json()) == one
    assert PlanView(planning=False, nodes=[], executed=[]).tree == GoalTree()


@pytest.mark.bus
async def test_the_trace_is_printed_with_the_rules_or_without(
    capsys: pytest.CaptureFixture[str],
):
    said = [" 11 n5 (goal)", "    Firing reject goal rule own to get (x)", " 12 n6 <op>"]
    lines = [TraceLine(seq=at, time=1.0, text=text) for at, text in enumerate(said, 1)]
    async with bus() as options, ScriptedModule("rogue", options=options) as agent:
        agent.answers(ReadTrace, lines, [], lines, [])
        flags = BusFlags(connect=options.connect, realm=options.realm)
        await trace(flags=flags)
        assert capsys.readouterr().out.splitlines() == said
        await trace(level=2, since="1h", flags=flags)
        assert capsys.readouterr().out.splitlines() == [said[0], said[2]]
        assert [asked.since for asked in agent.received(ReadTrace)] == [None, None, "1h", "1h"]


@pytest.mark.bus
async def test_why_is_printed_and_given_as_data(capsys: pytest.CaptureFixture[str]):
    entry = WhyEntry(time=5.0, kind="waits", sentence="It waits.", rule="own", over=("<x>",))
    report = WhyReport(id="a", sentences=["then: It waits."], entries=[entry])
    async with bus() as options, ScriptedModule("rogue", options=options) as agent:
        agent.answers(Why, report)
        flags = BusFlags(connect=options.connect, realm=options.realm)
        await why("a", everything=True, flags=flags)
        assert capsys.readouterr().out == "then: It waits.\n"
        await why("a", flags=BusFlags(connect=options.connect, realm=options.realm, json=True))
        assert json.loads(capsys.readouterr().out)["entries"] == [
            {"time": 5.0, "kind": "waits", "sentence": "It waits.", "rule": "own", "over": ["<x>"]}
        ]
        assert [asked.everything for asked in agent.received(Why)] == [True, False]
