"""The benchmark of simulators measures ours, and says which of the others are not there."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).parents[2] / "bench" / "sim.py"


@pytest.mark.process
def test_the_benchmark_prints_a_table_of_what_is_there():
    quick = ("--robots", "1", "2", "--rounds", "1", "--seconds", "0.01")
    done = subprocess.run(
        [sys.executable, str(BENCH), *quick, "--only", "ours", "navground", "ours-loop"],
        capture_output=True, text=True, check=True, timeout=50,
    )  # fmt: skip
    assert "| xavier_sim |" in done.stdout
    assert "| xavier_sim and navigate, dead reckoning |" in done.stdout
    there = importlib.util.find_spec("navground") is not None
    assert ("| navground |" in done.stdout) == there
    assert ("Not measured: navground is not installed." in done.stdout) != there
