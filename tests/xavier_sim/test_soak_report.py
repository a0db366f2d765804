"""The report of a soak: plots that are well-formed and true to scale, and nothing left out."""

from __future__ import annotations

import re
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_soak import job_of

from xavier_sim.soak import SoakOptions, report
from xavier_sim.soak._charts import Axis, bars, columns, curves, nice_step, points
from xavier_sim.soak._cost import Cost
from xavier_sim.soak._summary import summarise
from xavier_sim.soak._tally import Tally

SVG = "{http://www.w3.org/2000/svg}"
values = st.floats(0.0, 1e5, allow_subnormal=False)


def elements(svg, name):
    return ET.fromstring(svg).iter(f"{SVG}{name}")


@given(st.floats(1e-6, 1e6))
def test_steps_are_round_and_no_smaller_than_asked_for(least):
    step = nice_step(least)
    assert least <= step <= 2.51 * least
    assert re.fullmatch(r"[125](\.0+)?e[+-]\d+", f"{step:e}")


@given(st.lists(values, min_size=1, max_size=20))
@settings(max_examples=30)
def test_an_axis_holds_all_values_and_few_ticks(numbers):
    axis = Axis.over("x", numbers)
    assert axis.low == 0.0
    assert axis.high >= max(numbers)
    assert 2 <= len(axis.ticks()) <= 14
    assert all(0.0 <= axis.share(tick) <= 1.0 for tick in axis.ticks())


def test_points_lie_where_their_values_are():
    x, y = Axis("metres", 0.0, 10.0), Axis("seconds", 0.0, 100.0)
    svg = points("way & time", x, y, {"a": [(0.0, 0.0), (5.0, 50.0)], "b": [(10.0, 100.0)]})
    spots = [(float(c.get("cx")), float(c.get("cy"))) for c in elements(svg, "circle")]
    middle = ((spots[0][0] + spots[2][0]) / 2, (spots[0][1] + spots[2][1]) / 2)
    assert spots[1] == pytest.approx(middle)
    assert spots[2][0] > spots[0][0]
    assert spots[2][1] < spots[0][1]


def test_bars_are_as_long_as_their_counts():
    svg = bars("reasons", {"door_blocked": 4.0, "a <b>": 1.0})
    widths = [float(rect.get("width")) for rect in elements(svg, "rect")]
    assert widths[0] == pytest.approx(4.0 * widths[1], rel=1e-2)
    assert "a <b>" in [text.text for text in elements(svg, "text")]


@pytest.mark.parametrize(
    "svg",
    [
        bars("nothing", {}),
        curves("nothing", Axis.over("x", []), Axis.over("y", []), {"one": [], "two": []}),
        columns("nothing", Axis.over("x", []), Axis.over("y", []), []),
    ],
)
def test_charts_of_nothing_are_charts(svg):
    assert ET.fromstring(svg).tag == f"{SVG}svg"


def page(jobs):
    tally = Tally()
    tally.jobs = jobs
    for error in (0.01, 0.05, 0.2):
        tally.sample(error=error, speed=0.5)
    cost = Cost(wall=2.0, cpu=1.0, memory=80.0, memory_early=79.0)
    summary = summarise(tally, seconds=200.0, cost=cost, options=SoakOptions(seed=7))
    return summary, report(summary, tally)


def test_the_report_shows_every_job_that_did_not_end_as_it_should():
    jobs = [
        job_of(number=0),
        job_of(number=1, reason="lost", goal="r-<2>", metres=6.0),
        job_of(number=2, reason="door_blocked", way="shut"),
        job_of(number=3, off=0.9, goal="r-3", recoveries=2),
    ]
    summary, text = page(jobs)
    assert (summary.jobs, summary.completed, summary.false_arrivals) == (4, 1, 1)
    assert summary.reasons == {"lost": 1, "door_blocked": 1, "elsewhere": 1}
    assert (summary.reachable.jobs, summary.reachable.right) == (3, 1)
    assert (summary.unreachable.jobs, summary.unreachable.right) == (1, 1)
    assert summary.real_time_factor == 100.0
    wrong = text.split("What did not end as it should")[1].split("</table>")[0]
    assert re.findall(r"<tr><td>(\d+)</td>", wrong) == ["1", "3"]
    assert "r-&lt;2&gt;" in wrong
    assert text.count("<svg") == 5
    assert not re.search(r"(?:src|href)=", text), "the page needs nothing else"


def test_a_report_of_no_jobs_is_a_page():
    summary, text = page([])
    assert summary.reachable.share is None
    assert text.endswith("</body></html>\n")
