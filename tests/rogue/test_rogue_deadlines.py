from __future__ import annotations

from datetime import datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rogue.deadlines import read_deadline, read_moment
from rogue.errors import DeadlineError, MomentError
from rogue.times import show_deadline, show_time

NOW = datetime(2026, 3, 4, 14, 30).astimezone().timestamp()


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("+30m", 1800),
        ("30min", 1800),
        ("1h", 3600),
        ("1h30m", 5400),
        ("+ 2 h 5 min", 7500),
        ("90s", 90),
        ("14:45", 900),
        ("2026-03-04T15:00", 1800),
        ("2026-03-05 14:30", 86400),
        ("Thu Mar 5 14:30", 86400),
        ("mar  5 14:30", 86400),
        ("14:30 Thu Mar 5", 86400),
    ],
)
def test_times_as_people_write_them(text: str, seconds: float):
    assert read_deadline(text, NOW) == pytest.approx(NOW + seconds)


def test_a_clock_time_after_midnight_is_tomorrows():
    late = datetime(2026, 3, 4, 23, 50).astimezone().timestamp()
    assert read_deadline("00:20", late) == pytest.approx(late + 1800)


def test_iso_with_a_zone_is_that_zones_time():
    now = datetime.fromisoformat("2026-03-04T14:30:00+00:00").timestamp()
    assert read_deadline("2026-03-04T16:00:00+01:00", now) == pytest.approx(now + 1800)


@pytest.mark.parametrize(
    "text", ["soon", " ", "25:00", "1x", "+", "2026-13-01", "12:61", "h", "Fri Mar 5 14:30"]
)
def test_what_cannot_be_read_is_refused_with_the_forms(text: str):
    with pytest.raises(DeadlineError, match=r"cannot be read; expected .* HH:MM"):
        read_deadline(text, NOW)


@pytest.mark.parametrize("text", ["14:00", "2026-03-04T14:29", "0m", "2020-01-01"])
def test_what_has_passed_is_refused(text: str):
    with pytest.raises(DeadlineError, match="has passed"):
        read_deadline(text, NOW)


def test_a_slip_of_the_pen_is_refused():
    with pytest.raises(DeadlineError, match="more than a year"):
        read_deadline("99999h", NOW)


@given(st.text(max_size=30))
def test_any_text_gives_a_time_to_come_or_a_clear_refusal(text: str):
    try:
        deadline = read_deadline(text, NOW)
    except DeadlineError:
        deadline = NOW + 1
    assert deadline > NOW


@given(st.integers(min_value=1, max_value=300 * 24 * 60))
def test_relative_and_absolute_forms_agree(minutes: int):
    absolute = (datetime.fromtimestamp(NOW).astimezone() + timedelta(minutes=minutes)).isoformat()
    assert read_deadline(f"{minutes}min", NOW) == pytest.approx(NOW + minutes * 60)
    assert read_deadline(absolute, NOW) == pytest.approx(NOW + minutes * 60)


@pytest.mark.parametrize(
    ("text", "ago"), [("30m", 1800), ("1h30m", 5400), ("14:00", 1800), ("15:00", 84_600)]
)
def test_a_moment_lies_behind(text: str, ago: float):
    assert read_moment(text, NOW) == NOW - ago


def test_a_moment_that_cannot_be_read_is_refused():
    with pytest.raises(MomentError, match="since 'noon' cannot be read; expected ISO 8601"):
        read_moment("noon", NOW)


def test_times_read_like_those_of_figure_6():
    assert show_time(NOW) == "Mar 4 14:30"
    assert show_deadline(NOW) == "Wed Mar 4 14:30"


@given(st.integers(min_value=1, max_value=180 * 24 * 60))
def test_a_deadline_as_it_is_shown_can_be_read(minutes: int):
    deadline = NOW + minutes * 60
    assert read_deadline(show_deadline(deadline), NOW) == pytest.approx(deadline)


def test_a_day_of_the_new_year_is_the_next_one():
    late = datetime(2026, 12, 30, 12, 0).astimezone().timestamp()
    assert read_deadline("Jan 2 12:00", late) == pytest.approx(late + 3 * 86400)
