"""The programs of docs/errands.md do what the page says."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

from rogue.errands import Claim, load_metric

PAGE = Path(__file__).parents[3] / "docs" / "errands.md"
METRIC, TOUR = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def test_the_metric_of_the_page_can_be_used(tmp_path: Path):
    file = tmp_path / "fairness.py"
    file.write_text(METRIC)
    mail = Claim(user="mitchell", item="delivermail", posted=0.0)
    assert load_metric(f"{file}:fair")(mail, 600.0) == 110.0


def test_the_tour_of_the_page_prints_what_the_page_says():
    done = subprocess.run(
        [sys.executable, "-c", TOUR], capture_output=True, text=True, timeout=30, check=True
    )
    printed = re.findall(r"```text\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert [done.stdout] == printed
