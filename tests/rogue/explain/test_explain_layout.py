"""Tidy trees: nothing overlaps, parents stand over their children."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rogue.explain._layout import GAP, Layout, Size, lay_out

Forest = tuple[list[int], dict[int, list[int]], dict[int, Size]]


@st.composite
def forests(draw: st.DrawFn) -> Forest:
    count = draw(st.integers(1, 40))
    parents = [draw(st.integers(-1, one - 1)) for one in range(count)]
    children: dict[int, list[int]] = {}
    for one, parent in enumerate(parents):
        if parent >= 0:
            children.setdefault(parent, []).append(one)
    widths = st.floats(10.0, 300.0)
    sizes = {one: Size(draw(widths), draw(st.floats(10.0, 60.0))) for one in range(count)}
    return [one for one, parent in enumerate(parents) if parent < 0], children, sizes


def laid_out(forest: Forest) -> Layout:
    roots, children, sizes = forest
    return lay_out(roots, children, sizes, level_gap=30.0, row_width=800.0)


@given(forests())
def test_no_two_boxes_overlap(forest: Forest) -> None:
    places, sizes = laid_out(forest).places, forest[2]
    for one, other in itertools.combinations(places, 2):
        apart_x = abs(places[one].x - places[other].x)
        apart_y = abs(places[one].y - places[other].y)
        free_x = apart_x - (sizes[one].width + sizes[other].width) / 2
        free_y = apart_y - (sizes[one].height + sizes[other].height) / 2
        assert free_x > GAP - 0.01 or free_y > 10.0


@given(forests())
def test_a_parent_stands_over_the_middle_of_its_children(forest: Forest) -> None:
    places = laid_out(forest).places
    for parent, below in forest[1].items():
        middle = (places[below[0]].x + places[below[-1]].x) / 2
        assert places[parent].x == pytest.approx(middle)
        assert [places[one].x for one in below] == sorted(places[one].x for one in below)
        assert all(places[one].y > places[parent].y for one in below)


@given(forests())
def test_everything_lies_within_the_extent(forest: Forest) -> None:
    layout, sizes = laid_out(forest), forest[2]
    assert layout.places.keys() == sizes.keys()
    for one, place in layout.places.items():
        half_width, half_height = sizes[one].width / 2, sizes[one].height / 2
        assert place.x - half_width >= -0.01
        assert place.x + half_width <= layout.extent.width + 0.01
        assert place.y - half_height >= -0.01
        assert place.y + half_height <= layout.extent.height + 0.01


def test_trees_that_do_not_fit_beside_each_other_begin_a_row() -> None:
    sizes = {one: Size(300.0, 20.0) for one in range(3)}
    places = lay_out([0, 1, 2], {}, sizes, level_gap=30.0, row_width=800.0).places
    assert places[0].y == places[1].y < places[2].y
    assert places[0].x == places[2].x
