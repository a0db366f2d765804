from __future__ import annotations

import asyncio
import re
import sys
from pathlib import Path

import pytest

pytestmark = [pytest.mark.scenario, pytest.mark.process, pytest.mark.timeout(120)]

FIGURE_6 = Path(__file__).parents[1] / "rogue" / "figure6.txt"
COORDINATES = re.compile(r"MAPLOCDATA (\d+\.\d)d0 (\d+\.\d)d0")
MESSAGE = re.compile(r'(Message from interface: "mitchell" "delivermail") "[^"]+" "[^"]+" (.*)')
LAST_LINE = re.compile(
    r"Simulated \d+\.\d s, driven \d+\.\d m, "
    r"position error \d+\.\d\d m at r-5303, \d+\.\d\d m at r-5313\.$"
)


def comparable(text: str) -> list[str]:
    text = COORDINATES.sub("MAPLOCDATA X Y", text)
    return MESSAGE.sub(r'\1 "T" "T" \2', text).rstrip("\n").split("\n")


async def demo(*words: str) -> tuple[int, str, str]:
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "rogue",
        "demo",
        *words,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
    )
    out, err = await process.communicate()
    return process.returncode or 0, out.decode(), err.decode()


async def test_the_demo_prints_figure_6_and_what_it_measured():
    code, out, err = await demo()
    assert code == 0, err
    said, measured = out.rstrip("\n").rsplit("\n", 1)
    assert comparable(said) == comparable(FIGURE_6.read_text())
    assert LAST_LINE.match(measured), measured
    (x1, y1), (x2, y2) = [map(float, pair) for pair in COORDINATES.findall(said)]
    # The navigator's map is off by some centimetres from the one of the papers.
    assert (x1, y1) == pytest.approx((567.0, 2316.5), abs=30.0)
    assert (x2, y2) == pytest.approx((567.0, 4115.0), abs=30.0)
