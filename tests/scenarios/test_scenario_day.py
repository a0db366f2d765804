"""A small day on the robot of bad days, with people about, as ``rogue day`` has it."""

from __future__ import annotations

import pytest
from command_line import run_command

from rogue.cli import app

pytestmark = [pytest.mark.slow, pytest.mark.scenario, pytest.mark.process, pytest.mark.timeout(900)]


async def test_a_day_on_the_unkind_robot_ends_as_it_should():
    robot = ("--profile", "hard", "--people-walking", "2")
    numbers = ("--seed", "7", "--requests", "5", "--users", "4", "--hours", "0.15")
    ran = await run_command(app, "day", *numbers, *robot, "--json")
    # What went into wrong hands, or rooms, is among what is wrong.
    assert (ran.code, ran.json["wrong"]) == (0, []), ran.err
    day = ran.json["undisturbed"]
    ended = [(one["kind"], one["ended"]) for one in day["requests"]]
    assert ended == [
        ("canceled", "canceled"),
        *[("ordinary", "completed")] * 3,
        ("urgent", "completed"),
    ]
    arrivals = day["arrivals"]
    assert arrivals["elsewhere"] == 0
    sure_by_itself = arrivals["belief"] + arrivals["camera"]
    assert sure_by_itself > arrivals["person"] + arrivals["unsure"]
