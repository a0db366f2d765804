"""The metric of priorities and what it selects."""

from __future__ import annotations

from math import inf, nan
from pathlib import Path

import pytest
from errands_play import corridor

from rogue.errands import (
    Agenda,
    Claim,
    MetricError,
    OpenErrand,
    RankSum,
    Travel,
    guarded,
    load_metric,
    select,
)

CLAIM = Claim(user="mitchell", item="delivermail", person_rank=3, task_rank=2, deadline=1000.0)


def alphabetical(claim: Claim, _now: float) -> float:
    return -float(ord(claim.user[0]))


def broken(_claim: Claim, _now: float) -> float:
    return nan


class Constant:
    def __call__(self, _claim: Claim, _now: float) -> float:
        return 7.0


@pytest.mark.parametrize(
    ("now", "priority"), [(-9000.0, 5.0), (-800.0, 5.0), (100.0, 9.0), (1000.0, 13.0), (1e6, 13.0)]
)
def test_priority_is_the_sum_of_three_ranks(now: float, priority: float):
    assert RankSum()(CLAIM, now) == pytest.approx(priority)


def test_without_a_deadline_there_is_no_rank_for_it():
    assert RankSum().deadline_rank(inf) == 0.0


@pytest.mark.parametrize("name", ["alphabetical", "Constant"])
def test_a_metric_of_the_user_takes_the_place_of_the_sum(name: str):
    metric = load_metric(f"test_errands_priority:{name}")
    agenda = Agenda(travel=Travel(distance=corridor), metric=metric)
    agenda.put(CLAIM)
    assert agenda.priority("mitchell", "delivermail") == metric(CLAIM, 0.0)


def test_a_metric_may_stand_in_a_file(tmp_path: Path):
    file = tmp_path / "own_metric.py"
    file.write_text("def fair(claim, now):\n    return now - claim.posted\n")
    assert load_metric(f"{file}:fair")(CLAIM, 60.0) == 60.0


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("nothing", "it has no colon"),
        ("no.such.module:metric", "No module named 'no'"),
        ("no/such/file.py:metric", "FileNotFoundError"),
        ("math:nothing", "no attribute 'nothing'"),
        ("math:pi", "it is 3.14"),
        ("test_errands_priority:broken", "it gave nan"),
        ("math:sqrt", "raised TypeError"),
    ],
)
def test_a_metric_that_cannot_be_used_is_refused(name: str, problem: str):
    with pytest.raises(MetricError, match=problem):
        load_metric(name)


def test_where_a_metric_fails_the_sum_of_ranks_takes_its_place():
    complaints: list[MetricError] = []
    metric = guarded(broken, complaints.append)
    assert [metric(CLAIM, 0.0), metric(CLAIM, 0.0)] == [RankSum()(CLAIM, 0.0)] * 2
    assert len(complaints) == 1


def errand(key: str, pickup: str, deliver: str, rank: float, **fields: bool) -> OpenErrand:
    return OpenErrand(key=key, pickup=pickup, deliver=deliver, rank=rank, **fields)


def selected(errands: list[OpenErrand], **options: float) -> tuple[set[str], set[str]]:
    travel = Travel(distance=corridor, capacity=2)
    settings = {"nearby": 10.0, "margin": 1.0, **options}
    found = select(errands, start="r-5301", travel=travel, **settings)
    return set(found.top), set(found.compatible)


def test_errands_nearly_as_urgent_are_top_too():
    errands = [errand("a", "r-5303", "r-5305", 5.0), errand("b", "r-5399", "r-5303", 4.0)]
    assert selected(errands) == ({"a", "b"}, set())
    assert selected(errands, margin=0.5) == ({"a"}, set())


def test_what_lies_on_the_way_is_compatible():
    errands = [
        errand("top", "r-5311", "r-5321", 9.0),
        errand("on", "r-5305", "r-5315", 0.0),
        errand("against", "r-5315", "r-5305", 0.0),
        errand("beyond", "r-5321", "r-5399", 0.0),
    ]
    assert selected(errands) == ({"top"}, {"on"})


def test_detours_are_paid_together():
    """Each alone would do: 3.6 m there and 3.6 m back."""
    errands = [
        errand("top", "r-5303", "r-5311", 9.0),
        errand("one", "r-5311", "r-5313", 1.0),
        errand("two", "r-5303", "r-5301", 0.0),
    ]
    assert selected(errands, nearby=4.0) == ({"top"}, {"one"})
    assert selected(errands, nearby=20.0) == ({"top"}, {"one", "two"})


def test_what_fills_the_tray_is_served_before_something_urgent_is_fetched():
    errands = [
        errand("top", "r-5303", "r-5305", 9.0),
        errand("x", "", "r-5399", 0.0, carried=True),
        errand("y", "", "r-5397", 0.0, carried=True),
    ]
    assert selected(errands) == ({"top"}, {"x", "y"})


def test_what_is_decided_holds_for_a_moment():
    times = iter([90.0, 101.0, 119.9, 120.0])
    agenda = Agenda(travel=Travel(distance=corridor), now=lambda: next(times))
    first, *same, later = (agenda.priority_of(CLAIM) for _ in range(4))
    assert same == [first, first]
    assert later > first
