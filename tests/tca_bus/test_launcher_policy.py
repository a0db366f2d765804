"""The launcher's pure parts: restart policy, start order, lines."""

from __future__ import annotations

import io
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tca_bus import ConfigError
from tca_bus.launcher import ProcessSpec, RestartPolicy
from tca_bus.launcher._logs import LONGEST_LINE, Console, LineCutter, LogFile
from tca_bus.launcher._restart import RestartHistory
from tca_bus.launcher._spec import start_order

POLICY = RestartPolicy(
    first_delay=1.0, factor=2.0, longest_delay=5.0, calm_after=10.0, most=6, window=100.0
)


def test_delays_grow_up_to_the_longest():
    history = RestartHistory(POLICY)
    delays = [history.crashed(now=float(now), ran_for=0.1) for now in range(5)]
    assert delays == [1.0, 2.0, 4.0, 5.0, 5.0]


def test_a_calm_run_begins_again_at_the_first_delay():
    history = RestartHistory(POLICY)
    for now in range(3):
        history.crashed(now=float(now), ran_for=0.1)
    assert history.crashed(now=20.0, ran_for=15.0) == 1.0


def test_too_many_crashes_in_the_window_give_up():
    history = RestartHistory(POLICY)
    delays = [history.crashed(now=float(now), ran_for=0.1) for now in range(7)]
    assert delays[-1] is None
    assert None not in delays[:-1]
    assert history.crashes == 7


def test_crashes_leave_the_window():
    history = RestartHistory(POLICY)
    delays = [history.crashed(now=50.0 * turn, ran_for=0.1) for turn in range(50)]
    assert None not in delays


@given(
    gaps=st.lists(st.floats(0.0, 60.0), min_size=1, max_size=60),
    runs=st.lists(st.floats(0.0, 60.0), min_size=60, max_size=60),
)
def test_a_delay_is_within_bounds_or_the_window_is_full(gaps, runs):
    history = RestartHistory(POLICY)
    now, times = 0.0, []
    for gap, run in zip(gaps, runs, strict=False):
        now += gap
        times.append(now)
        recent = [when for when in times if when >= now - POLICY.window]
        delay = history.crashed(now=now, ran_for=run)
        if delay is None:
            assert len(recent) > POLICY.most
            return
        assert len(recent) <= POLICY.most
        assert POLICY.first_delay <= delay <= POLICY.longest_delay


@pytest.mark.parametrize(
    ("field", "value"), [("first_delay", -1.0), ("factor", 0.5), ("window", float("nan"))]
)
def test_a_policy_names_the_field_that_is_wrong(field, value):
    with pytest.raises(ConfigError, match=f"RestartPolicy.{field}"):
        RestartPolicy(**{field: value})


def test_order_waits_for_all_earlier_ones_unless_told():
    specs = [
        ProcessSpec("router", ["a"]),
        ProcessSpec("central", ["b"]),
        ProcessSpec("xavier", ["c"], after=["router"]),
    ]
    assert start_order(specs) == {
        "router": (),
        "central": ("router",),
        "xavier": ("router",),
    }


def test_order_refuses_a_later_name_and_suggests_one():
    specs = [ProcessSpec("router", ["a"]), ProcessSpec("central", ["b"], after=["ruoter"])]
    with pytest.raises(ConfigError, match="Did you mean 'router'"):
        start_order(specs)


def test_order_refuses_a_name_twice():
    with pytest.raises(ConfigError, match="no other process has"):
        start_order([ProcessSpec("a", ["x"]), ProcessSpec("a", ["y"])])


@pytest.mark.parametrize(("name", "argv"), [("no/slash", ["x"]), ("", ["x"]), ("ok", [])])
def test_a_spec_that_cannot_run_is_refused(name, argv):
    with pytest.raises(ConfigError):
        ProcessSpec(name, argv)


@given(st.lists(st.binary(max_size=40), max_size=20))
def test_lines_do_not_depend_on_how_the_bytes_arrive(chunks):
    whole, cut = LineCutter(), LineCutter()
    at_once = whole.feed(b"".join(chunks)) + whole.finish()
    in_pieces = [line for chunk in chunks for line in cut.feed(chunk)] + cut.finish()
    assert in_pieces == at_once


@given(st.lists(st.text(st.characters(exclude_characters="\n\r", codec="utf-8"))))
def test_lines_come_back_as_written(lines):
    cutter = LineCutter()
    data = "".join(line + "\n" for line in lines).encode()
    assert cutter.feed(data) == lines
    assert not cutter.pending


def test_an_endless_line_is_cut():
    cutter = LineCutter()
    lines = cutter.feed(b"x" * (LONGEST_LINE * 2 + 5))
    assert [len(line) for line in lines] == [LONGEST_LINE, LONGEST_LINE]
    assert cutter.finish() == ["xxxxx"]


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_names_are_aligned_and_plain_away_from_a_terminal():
    stream = io.StringIO()
    console = Console(stream, ["router", "xavier", "me"], environ={})
    console.write("me", "hello")
    console.write("router", "world")
    assert stream.getvalue() == "me     | hello\nrouter | world\n"


def test_each_name_has_its_colour_on_a_terminal():
    stream = Terminal()
    console = Console(stream, ["a", "b", "c"], environ={})
    for name in "abc":
        console.write(name, "x")
    colours = [line.split("m")[0] for line in stream.getvalue().splitlines()]
    assert all(colour.startswith("\x1b[") for colour in colours)
    assert all(one != two for one, two in pairwise(sorted(colours)))


def test_no_color_is_respected():
    stream = Terminal()
    Console(stream, ["a"], environ={"NO_COLOR": "1"}).write("a", "x")
    assert stream.getvalue() == "a | x\n"


def test_a_log_file_moves_on_when_it_is_full(tmp_path):
    file = LogFile(tmp_path / "logs" / "x.log", limit=30)
    for number in range(12):
        file.write(f"line {number:04}")
    file.close()
    kept = [path.read_text() for path in sorted((tmp_path / "logs").iterdir(), reverse=True)]
    assert len(kept) == 2
    assert "".join(kept).splitlines()[-1] == "line 0011"
    assert all(len(text) <= 50 for text in kept)
