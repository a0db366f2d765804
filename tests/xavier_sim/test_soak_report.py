"""The report of a soak: plots that are well-formed and true to scale, and nothing left out."""

from __future__ import annotations

import html
import re
from dataclasses import replace
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_soak import FLOOR, job_of
from test_soak_postmortem import facts_of

from xavier_sim.soak import Outcome, SoakOptions, explain, report, together
from xavier_sim.soak._charts import Axis, bars, columns, curves, nice_step, plan_view, points
from xavier_sim.soak._cost import Cost
from xavier_sim.soak._door_rates import door_rates
from xavier_sim.soak._figure_rows import figure_rows
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


def outcome_of(jobs, seed=7):
    tally = Tally()
    tally.jobs = jobs
    for error in (0.01, 0.05, 0.2):
        tally.sample(error=error, speed=0.5)
    cost = Cost(wall=2.0, cpu=1.0, memory=80.0, memory_early=79.0)
    return Outcome(SoakOptions(seed=seed, floor=FLOOR), tally, 200.0, cost)


def page(jobs):
    outcome = outcome_of(jobs)
    return outcome.summary(), report([outcome])


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
    assert summary.navigator_settings == {"localizer": "pomdp", "policy": "voting"}
    assert "<td>localizer pomdp, policy voting</td>" in text
    wrong = text.split("What did not end as it should")[1].split("</table>")[0]
    assert re.findall(r"<tr><td>7</td><td>(\d+)</td>", wrong) == ["1", "3"]
    assert "r-&lt;2&gt;" in wrong
    assert text.count("<svg") == 7
    assert not re.search(r"(?:src|href)=", text), "the page needs nothing else"


def test_the_report_says_why_jobs_failed_by_the_truth():
    facts = facts_of(space="<hall>", believed_x=4.0, along=-1.0, turned=3.0)
    jobs = [job_of(number=3, reason="lost", post_mortem=facts), job_of(number=4, reason="lost")]
    summary, text = page(jobs)
    why = explain(jobs[0], facts)
    assert [(one.number, one.why, one.facts) for one in summary.failures] == [(3, why, facts)]
    told = text.split("Failures, explained</h2>")[1].split("</table>")[0]
    rows = [re.findall(r"<td>(.*?)</td>", line) for line in told.splitlines() if "<td>" in line]
    assert rows == [
        ["7", "3", "0.000", "r-1", "r-2", "lost", "-1.0", "0.0", "3.0", html.escape(why)],
    ]
    assert "&lt;hall&gt;" in rows[0][-1]


def test_a_report_of_no_jobs_is_a_page():
    summary, text = page([])
    assert summary.reachable.share is None
    assert text.endswith("</body></html>\n")


def test_soaks_of_several_seeds_are_added_up():
    one = outcome_of([job_of(metres=8.0), job_of(number=1, reason="lost")], seed=1)
    two = outcome_of([job_of(metres=4.0, bumps=3)], seed=2)
    figures, tally = together([one, two])
    assert (figures.jobs, figures.completed, figures.bumps) == (3, 2, 3)
    assert figures.hours == round(400.0 / 3600.0, 4)
    assert figures.reasons == {"lost": 1}
    assert figures.real_time_factor == one.summary().real_time_factor
    assert tally.errors.total == 6
    assert one.tally.errors.total == 3, "what was added is as it was"
    text = report([one, two])
    assert "seeds 1, 2" in text
    assert "<tr><td>jobs</td><td>2</td><td>1</td><td>3</td></tr>" in text


def test_doors_are_summed_up_and_told_one_by_one():
    jobs = [
        job_of(recoveries=1),
        job_of(number=1, recoveries=2, reason="door_blocked"),
        job_of(number=2, goal="r-3"),
        job_of(number=3, goal="r-3", way="shut", reason="door_blocked"),
        job_of(number=4, goal="before r-3", bumps=1),
        job_of(number=5, goal="before r-3", recoveries=1, off=0.7),
    ]
    _, text = page(jobs)
    doors = text.split("Rooms and their doors")[1].split("</table>")[0]
    rows = [re.findall(r"<td>(.*?)</td>", line) for line in doors.splitlines() if "<td>" in line]
    assert rows == [
        ["all", "5", "3", "3", "60.00", "1", "33.33", "1", "20.00", "1", "1"],
        ["r-2", "2", "1", "2", "100.00", "1", "50.00", "1", "50.00", "0", "0"],
        ["r-3", "3", "2", "1", "33.33", "0", "0.00", "0", "0.00", "1", "1"],
    ]


def test_a_drive_that_is_given_up_at_the_first_trouble_was_stuck():
    rates = door_rates([job_of(reason="door_blocked"), job_of(), job_of(way="changing")])
    assert (rates.drives, rates.completed) == (2, 1)
    assert (rates.stuck, rates.recovered, rates.given_up) == (1, 0, 1)
    assert (rates.stuck_share, rates.recovered_share, rates.given_up_share) == (0.5, 0.0, 0.5)
    nothing = door_rates([])
    assert nothing.stuck_share is nothing.recovered_share is nothing.given_up_share is None


def test_door_rates_are_figures_of_errands_in_and_out_only():
    jobs = [job_of(recoveries=1), job_of(number=1, goal="before r-2")]
    plain = outcome_of(jobs)
    tried = replace(plain, options=plain.options.model_copy(update={"doors_in_and_out": 1}))
    assert plain.summary().doors is None
    total, _ = together([tried, tried])
    assert (total.doors.drives, total.doors.stuck, total.doors.stuck_share) == (4, 2, 0.5)
    rows = figure_rows([tried.summary(), total, plain.summary()])
    assert rows[-4:] == [
        ("drives through doors that were open", "2", "4", ""),
        (
            "of those: stuck, there or elsewhere on the drive",
            "1 of 2 (50.00 %)",
            "2 of 4 (50.00 %)",
            "",
        ),
        ("of the stuck: recovered and arrived", "1 of 1 (100.00 %)", "2 of 2 (100.00 %)", ""),
        ("of all: given up", "0 of 2 (0.00 %)", "0 of 4 (0.00 %)", ""),
    ]
    assert len(figure_rows([plain.summary()])) == len(rows) - 4


def test_places_are_drawn_to_scale():
    box = [(0.0, 0.0, 10.0, 0.0), (10.0, 0.0, 10.0, 4.0)]
    svg = plan_view("where", box, {"a": [(0.0, 0.0)], "b": [(10.0, 4.0), (5.0, 2.0)]})
    walls, one, two = (path.get("d") for path in elements(svg, "path"))
    corner, far, middle = (
        tuple(map(float, at.split())) for at in re.findall(r"M([\d. ]+)h0", one + two)
    )
    assert (far[0] + corner[0]) / 2 == pytest.approx(middle[0])
    assert (far[1] + corner[1]) / 2 == pytest.approx(middle[1])
    assert far[1] < corner[1], "north is up"
    assert (far[0] - corner[0]) / (corner[1] - far[1]) == pytest.approx(2.5)
    assert walls.startswith(f"M{corner[0]} {corner[1]}L")


def test_a_floor_that_is_higher_than_wide_lies_on_its_side():
    svg = plan_view("where", [(0.0, 0.0, 4.0, 10.0)], {"a": [(0.0, 0.0), (4.0, 10.0), (4.0, 0.0)]})
    _, dots = (path.get("d") for path in elements(svg, "path"))
    south_west, north_east, south_east = (
        tuple(map(float, at.split())) for at in re.findall(r"M([\d. ]+)h0", dots)
    )
    assert north_east[0] > south_west[0] == south_east[0], "north is to the right"
    assert south_east[1] == north_east[1] > south_west[1], "east is down"
    assert "north to the right" in svg


@pytest.mark.parametrize(("faults", "shown"), [((0,), False), ((0, 3), True)])
def test_how_often_a_fault_struck_is_told_where_one_did(faults, shown):
    plain = outcome_of([job_of()]).summary()
    columns = [plain.model_copy(update={"faults": count}) for count in faults]
    rows = {name: cells for name, *cells in figure_rows(columns)}
    assert ("times that the fault struck" in rows) is shown
    assert rows["jobs"] == ["1"] * len(faults)
