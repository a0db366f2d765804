"""``xavier fault``: every kind is made, listed and mended, and bad values are named."""

from __future__ import annotations

import json

import pytest
from test_xavier_bus import robot

from tca_bus import ConfigError, Module
from tca_bus.testing import bus
from xavier_sim.cli._faults import fault
from xavier_sim.floors import load_floor
from xavier_sim.messages import Mend, ReadFaults, SonarFault, WheelSlip
from xavier_sim.profile import HARD
from xavier_sim.running import make_fault
from xavier_sim.world import World

PLAN = load_floor()

LASTING = {
    "wheels 0.3 --veer 0.05": ("wheels", {"share": 0.3, "veer": 0.05}),
    "camera off": ("camera_on", False),
    "odometry 1.5": ("slip", 1.5),
    "sonar 3 dead": ("sonars", [{"number": 3, "state": "dead"}]),
    "laser --metres 0.2": ("laser", {"metres": 0.2}),
}


async def run(words):
    await fault.run_async(
        words, exit_on_error=False, print_error=False, result_action="return_value"
    )


async def call(options, capsys, words):
    """Run one command in this process, and give what it prints as JSON."""
    flags = ["--connect", options.connect, "--realm", options.realm, "--json"]
    await run([*words.split(), *flags])
    return json.loads(capsys.readouterr().out)


def holds(told, wanted):
    """Whether what was told has all that was wanted in it."""
    if isinstance(wanted, dict):
        return all(holds(told[name], value) for name, value in wanted.items())
    if isinstance(wanted, list):
        return len(told) == len(wanted) and all(map(holds, told, wanted))
    return told == wanted


@pytest.mark.bus
async def test_what_lasts_is_listed_until_it_is_cleared(capsys):
    async with (
        bus() as options,
        robot(options, world=World(PLAN, 1, HARD)),
        Module("asker", options=options) as asker,
    ):
        await asker.wait_for(ReadFaults, timeout=10)
        sound = await call(options, capsys, "list")
        for words, (field, value) in LASTING.items():
            made = await call(options, capsys, words)
            assert holds(made[field], value), words
        listed = await call(options, capsys, "list")
        assert all(holds(listed[field], value) for field, value in LASTING.values())
        cleared = await call(options, capsys, "clear")
        assert {**cleared, "tick": 0, "time": 0} == {**sound, "tick": 0, "time": 0}


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("wheels 0.9", "share is 0.9, expected less than or equal to 0.8"),
        ("wheels nan", "share is nan, expected"),
        ("wheels 0.1 --veer inf", "veer is inf, expected less than or equal to 0.5"),
        ("odometry nan", "metres is nan, expected"),
        ("odometry 51", "metres is 51.0, expected less than or equal to 50"),
        ("sonar 24 dead", "number is 24, expected less than 24"),
        (
            "sonar 3 dead --metres 1",
            "the fault is 'number 3, .*', expected no metres for a dead",
        ),
        ("laser --metres nan", "metres is nan, expected"),
        ("kidnap --x nan --y 1", "x is nan, expected a finite number"),
        ("kidnap r-5303 --heading inf", "heading is inf, expected a finite number"),
        ("kidnap --x 1", "the fault is 'x 1.0, .*', expected both x and y, or neither"),
        ("kidnap", "the fault is '.*', expected a room, or x and y, or ahead and left"),
    ],
)
async def test_what_cannot_be_is_refused_before_anybody_is_asked(words, says):
    with pytest.raises(ConfigError, match=says):
        await run(words.split())


def test_help_names_every_kind(capsys):
    fault(["--help"], result_action="return_value")
    told = capsys.readouterr().out
    kinds = ("camera", "clear", "item-brought", "item-taken", "kidnap", "laser", "list")
    assert all(kind in told for kind in (*kinds, "odometry", "sonar", "wheels"))


def test_mending_leaves_other_robots_as_they_are():
    world = World(PLAN, robots=("xavier", "yoda"))
    for name in world.robots:
        make_fault(world, WheelSlip(share=0.2), name)
        make_fault(world, SonarFault(number=1, state="dead"), name)
    make_fault(world, Mend(), "yoda")
    assert world.robot.wheels.slip == 0.2
    assert world.robots["yoda"].wheels.slip == 0.0
    assert not world.robots["yoda"].senses.stuck_sonars


def test_slipping_wheels_survive_a_snapshot():
    world, again = World(PLAN), World(PLAN)
    make_fault(world, WheelSlip(share=0.2, veer=-0.1))
    again.restore(json.loads(json.dumps(world.snapshot())))
    assert (again.robot.wheels.slip, again.robot.wheels.veer) == (0.2, -0.1)
