"""The benchmarks of simulators and soaks print what they measure, and what is not there."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).parents[2] / "bench"
FLOOR = Path(__file__).parent / "soak_floor.yaml"


@pytest.mark.process
def test_the_benchmark_prints_a_table_of_what_is_there():
    quick = ("--robots", "1", "2", "--rounds", "1", "--seconds", "0.01")
    done = subprocess.run(
        [sys.executable, str(BENCH / "sim.py"), *quick, "--only", "ours", "navground", "ours-loop"],
        capture_output=True, text=True, check=True, timeout=50,
    )  # fmt: skip
    assert "| xavier_sim |" in done.stdout
    assert "| xavier_sim and navigate, dead reckoning |" in done.stdout
    there = importlib.util.find_spec("navground") is not None
    assert ("| navground |" in done.stdout) == there
    assert ("Not measured: navground is not installed." in done.stdout) != there


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.timeout(150)
def test_a_soak_over_the_bus_has_the_jobs_of_the_one_in_one_process():
    options = ("--map", str(FLOOR), "--hours", "0.004", "--seed", "3", "--bus")
    done = subprocess.run(
        [sys.executable, str(BENCH / "soak.py"), *options],
        capture_output=True, text=True, check=True, timeout=140,
    )  # fmt: skip
    rows = [line.split(" | ") for line in done.stdout.splitlines() if line.startswith("| ")]
    names = [row[0].strip("| ") for row in rows]
    assert names == ["run", "---", "plain", "over the bus"]
    plain, bus = (dict(zip(rows[0][1:-4], row[1:-4], strict=False)) for row in rows[2:])
    assert plain == bus
    assert int(plain["jobs"]) >= 1
    jobs = plain["jobs"]
    assert f"Of {jobs} jobs that both runs had, {jobs} are the same in every figure" in done.stdout
