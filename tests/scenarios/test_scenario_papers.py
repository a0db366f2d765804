"""The papers' scenarios on the whole system, as ``rogue demo`` plays them."""

from __future__ import annotations

import asyncio
import re
import sys
from pathlib import Path

import pytest

pytestmark = [pytest.mark.slow, pytest.mark.scenario, pytest.mark.process, pytest.mark.timeout(150)]

FIGURES = Path(__file__).parents[1] / "rogue"
NODE = re.compile(r" *\d+ +n\d+ ")
DELIVER = "(GOTO-DELIVER-LOC mitchell r-5313)"
PICKUP = "(GOTO-PICKUP-LOC mitchell r-5303)"
ACQUIRE = "(ACQUIRE-ITEM r-5303 mitchell delivermail)"
PICKUP_FAX = "(GOTO-PICKUP-LOC jhm r-5311)"
ACQUIRE_FAX = "(ACQUIRE-ITEM r-5311 jhm deliverfax)"
DONE = re.compile(r" *COMPLETED-ACTION \(([A-Z-]+) 1 (.*)\)")


async def conversation(name: str) -> list[str]:
    """What a scenario prints."""
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *("-m", "rogue", "demo", name),
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    out, err = await process.communicate()
    assert process.returncode == 0, out.decode() + err.decode()
    return out.decode().splitlines()


def planned(lines: list[str]) -> list[str]:
    """The planner's lines as the figures have them."""
    shown = [line for line in lines if NODE.match(line) or line == "Achieved top-level goals."]
    return [line for line in shown if "warning" not in line]


def done(lines: list[str]) -> list[str]:
    """The actions that were completed, in order."""
    found = (DONE.match(line) for line in lines)
    return [f"{match[1]} {match[2]}" for match in found if match]


def figure(name: str) -> list[str]:
    return (FIGURES / f"{name}.txt").read_text().splitlines()


async def test_two_requests_are_planned_for_as_in_figure_9():
    assert planned(await conversation("figure9")) == figure("figure9")


async def test_the_1998_example_is_planned_with_its_lists_at_each_step():
    lines = await conversation("example1998")
    assert planned(lines) == figure("example1998")
    told = [line.strip() for line in lines]
    steps = [
        ("(has-item mitchell delivermail)", "nil", "nil"),
        ("nil", f"(and {DELIVER} {PICKUP})", "nil"),
        ("nil", DELIVER, "nil"),
        ("(has-item jhm deliverfax)", DELIVER, "nil"),
        ("(has-item jhm deliverfax)", f"(and {DELIVER} {ACQUIRE})", PICKUP),
        ("nil", f"(and {DELIVER} {ACQUIRE} {PICKUP_FAX})", PICKUP),
        ("nil", f"(and {DELIVER} {PICKUP_FAX})", PICKUP),
        ("nil", f"(and {DELIVER} {ACQUIRE_FAX})", PICKUP),
    ]
    at = 0
    for pending, applicable, executed in steps:
        block = [
            f"PG is {pending}",
            f"Applicable-Ops is {applicable}",
            f"Executed-Ops is {executed}",
        ]
        at = next(i for i in range(at, len(told)) if told[i : i + 3] == block)


async def test_after_a_wrong_arrival_the_search_goes_on_from_there():
    lines = await conversation("failure")
    warned = [line for line in lines if line.endswith("warning: desired goal was not achieved")]
    assert [line.split()[1] for line in warned] == ["n18"]
    assert planned(lines)[-7:] == [
        " 18       n19 (robot-in-room r-5303)",
        " 20       n21 <goto-pickup-loc mitchell r-5303>",
        " 21       n22 <GOTO-PICKUP-LOC MITCHELL R-5303>",
        " 22     n23 <ACQUIRE-ITEM R-5303 MITCHELL DELIVERMAIL>",
        " 23     n24 <GOTO-DELIVER-LOC MITCHELL R-5313>",
        " 23   n25 <DELIVER-ITEM R-5313 MITCHELL DELIVERMAIL>",
        "Achieved top-level goals.",
    ]


async def test_a_plan_half_done_is_merged_with_another():
    assert done(await conversation("figure11")) == [
        "GOTO-LOCATION R-5303",
        'ACQUIRE-ITEM "Tom Mitchell\'s mail delivery"',
        "GOTO-LOCATION R-5307",
        'ACQUIRE-ITEM "Reid Simmons\'s library book"',
        "GOTO-LOCATION R-5313",
        'DELIVER-ITEM "Tom Mitchell\'s mail delivery"',
        "GOTO-LOCATION R-5321",
        'DELIVER-ITEM "Reid Simmons\'s library book"',
    ]


LETTERS, FAX = '"Richard Goodwin\'s outgoing mail"', '"James Morris\'s fax delivery"'
IMPORTANT = [
    "GOTO-LOCATION R-5409",
    f"ACQUIRE-ITEM {FAX}",
    "GOTO-LOCATION R-5420",
    f"DELIVER-ITEM {FAX}",
]


async def test_an_interrupted_errand_is_taken_up_where_it_was():
    assert done(await conversation("normal")) == [
        "GOTO-LOCATION R-5301",
        f"ACQUIRE-ITEM {LETTERS}",
        *IMPORTANT,
        "GOTO-LOCATION R-5315",
        f"DELIVER-ITEM {LETTERS}",
    ]


async def test_what_was_undone_meanwhile_is_done_again():
    assert done(await conversation("undone")) == [
        "GOTO-LOCATION R-5301",
        *IMPORTANT,
        "GOTO-LOCATION R-5301",
        f"ACQUIRE-ITEM {LETTERS}",
        "GOTO-LOCATION R-5315",
        f"DELIVER-ITEM {LETTERS}",
    ]
