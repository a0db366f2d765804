"""Drawings of robot, belief and floor, as SVG and as text."""

from __future__ import annotations

import math
import re
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from navigate_loop import Loop

from navigate.cli._drawing import Scene, write
from navigate.reporting import outlook
from navigate.view import draw_svg, draw_text
from navigate.view._belief import opacity
from navigate.view._braille import Braille
from navigate.view._ink import Pane, Window
from navigate.view._words import counted
from tca_bus import ConfigError
from xavier_sim.messages import LIDAR_BEAMS, STRIPER_BEAMS, FloorPlan

ZERO = {"x": 0, "y": 0}


@pytest.fixture(scope="module")
def scene():
    """A robot on its way, a shut door, and a belief that is not quite sure."""
    loop = Loop(seed=3)
    loop.world.set_door("d-5307", is_open=False)
    loop.start("r-5303")
    for _ in range(80):
        loop.tick()
    loop.navigator.memory.shut("d-5309", loop.navigator.time)
    loop.navigator.memory.blocked((8.0, 30.0), loop.navigator.time)
    loop.navigator.localizer.widen(spread=0.8, turn_spread=0.3)
    told = outlook(loop.navigator, loop.sensors, loop.navigator.driver.drive, "task")
    world = loop.robot.world_view()
    return told, loop.navigator.floor.plan, world


def parts(drawing, kind):
    return [one for one in ET.fromstring(drawing).iter() if one.get("class") == kind]


def test_simulator_and_navigator_stand_side_by_side(scene):
    told, plan, world = scene
    drawing = draw_svg(told, plan, world)
    assert [one.text for one in parts(drawing, "title")] == ["Simulator", "Navigator"]
    assert len(parts(drawing, "frame")) == 4
    assert len(parts(drawing, "body")) == 4
    echoes = sum(reading is not None for reading in told.sonar)
    assert len(parts(drawing, "echo")) == len(parts(drawing, "cone")) == 2 * echoes
    assert len(parts(drawing, "silent")) == 2 * (24 - echoes)
    squares = {(math.floor(cell.x), math.floor(cell.y)) for cell in told.belief.cells}
    assert len(parts(drawing, "cell")) >= len(squares) > 1
    assert len(parts(drawing, "goal")) == 2
    assert len(parts(drawing, "shut")) >= 2
    assert len(parts(drawing, "blocked")) == 2
    words = " ".join(one.text for one in parts(drawing, "fact"))
    assert "to r-5303" in words
    assert "believed 0." in words


def test_where_nobody_knows_the_truth_the_navigator_stands_alone(scene):
    told, plan, _ = scene
    drawing = draw_svg(told, plan)
    assert [one.text for one in parts(drawing, "title")] == ["Navigator"]
    assert len(drawing) < 100_000


def test_an_idle_robot_without_readings_is_drawn(scene):
    told, _, _ = scene
    idle = told.model_copy(update={"sonar": [], "drive": None, "way": [], "bump": 0b1001})
    tiny = FloorPlan.model_validate(
        {
            "name": "tiny",
            "spaces": [
                {
                    "name": "hall",
                    "kind": "corridor",
                    "low": {"x": 0, "y": 0},
                    "high": {"x": 9, "y": 2},
                }
            ],
            "doors": [],
            "places": {},
            "start": {"x": 1, "y": 1},
        }
    )
    drawing = draw_svg(idle, tiny)
    assert len(parts(drawing, "touch")) == 2
    assert not parts(drawing, "goal")
    assert "no drive under way" in draw_text(idle, tiny, None, columns=60, rows=20)
    with pytest.raises(ConfigError, match="--svg is '/', expected a file that can be written"):
        write(Scene(idle, tiny, None), Path("/"))


def test_what_lasers_see_stands_where_it_is():
    loop = Loop()
    striper = np.full(STRIPER_BEAMS, np.inf, dtype=np.float32)
    striper[[0, 15]] = 1.0
    lidar = np.full(LIDAR_BEAMS, np.inf, dtype=np.float32)
    lidar[-1] = 2.0
    sensors = loop.sensors.model_copy(update={"striper": striper, "lidar": lidar})
    told = outlook(loop.navigator, sensors, None, "")
    askance = math.radians(15.0)
    assert told.seen == [
        pytest.approx((0.25 + math.cos(askance), -math.sin(askance)), abs=1e-3),
        pytest.approx((1.25, 0.0), abs=1e-3),
        pytest.approx(
            (2.0 * math.cos(math.radians(179)), 2.0 * math.sin(math.radians(179))), abs=1e-3
        ),
    ]
    assert len(parts(draw_svg(told, loop.navigator.floor.plan), "seen")) == 3


WINDOWS = st.builds(
    Window.about,
    st.tuples(st.floats(-50, 50), st.floats(-50, 50)),
    st.floats(1.0, 100.0),
    st.floats(1.0, 100.0),
)


@given(WINDOWS, st.floats(0.01, 0.99), st.floats(0.01, 0.99))
def test_what_lies_in_the_window_lies_in_the_pane(window, east, north):
    page = ET.Element("svg")
    pane = Pane(page, window, (10.0, 20.0), (300.0, 200.0))
    pane.disc("spot", (window.x0 + east * window.width, window.y0 + north * window.height), 0.1)
    drawn = next(one for one in page.iter("circle"))
    assert 0.0 <= float(drawn.get("cx")) <= 300.0
    assert 0.0 <= float(drawn.get("cy")) <= 200.0
    middle = 150.0 + (east - 0.5) * window.width * pane.scale
    assert float(drawn.get("cx")) == pytest.approx(middle, abs=0.06)


@given(WINDOWS, st.integers(4, 60), st.integers(3, 30), st.data())
def test_a_dot_of_braille_stands_where_its_point_is(window, columns, rows, data):
    page = Braille(window, columns, rows)
    east, north = (data.draw(st.floats(0.01, 0.99)) for _ in range(2))
    page.dot((window.x0 + east * window.width, window.y0 + north * window.height))
    lines = page.lines()
    assert len(lines) == rows
    assert all(len(line) == columns for line in lines)
    dots = [ord(character) - 0x2800 for line in lines for character in line if character != " "]
    assert len(dots) == 1
    assert dots[0].bit_count() == 1
    column = next(line for line in lines if line.strip()).rstrip()
    across = columns + (east - 0.5) * window.width * page.scale
    assert abs(2 * (len(column) - 1) + 0.5 - across) <= 1.6


def test_the_text_shows_robot_goal_truth_and_fits(scene):
    told, plan, world = scene
    off = world.robot.model_copy(update={"x": world.robot.x + 1.0, "y": world.robot.y + 3.0})
    text = draw_text(told, plan, world.model_copy(update={"robot": off}), columns=100, rows=40)
    lines = text.splitlines()
    assert len(lines) == 40
    assert max(map(len, lines[:35])) <= 100
    assert "◎" in text
    assert re.search("[→↗↑↖←↙↓↘]", text)
    assert text.count("×") == 2
    small = draw_text(told, plan, None, columns=40, rows=12)
    assert len(small.splitlines()) == 10


@given(st.floats(0, 1), st.floats(0, 1))
def test_more_belief_is_drawn_more_strongly(one, other):
    assert (opacity(one) <= opacity(other)) == (one <= other) or opacity(one) == opacity(other)
    assert 0.1 < opacity(one) < 0.9


@pytest.mark.parametrize(
    ("number", "what", "words"),
    [(1, "bump", "1 bump"), (0, "bump", "0 bumps"), (2, "recovery", "2 recoveries")],
)
def test_things_are_counted(number, what, words):
    assert counted(number, what) == words
