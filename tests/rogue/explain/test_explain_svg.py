"""Drawings of goal trees: what is in them, and that any name may be."""

from __future__ import annotations

import runpy
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rogue.explain import draw_svg
from rogue.explain._scene import MOST_GONE, compose
from rogue.prodigy import GoalTree, Standing, TreeNode, TreeStep

DOCS = Path(__file__).parents[3] / "docs"
SVG = "{http://www.w3.org/2000/svg}"


def goal(number: int, name: str = "holds", above: int = 0, **more: object) -> TreeNode:
    return node(number, is_goal=True, name=name, above=above, **more)


def node(number: int, **more: object) -> TreeNode:
    values: dict[str, object] = {
        "is_goal": False,
        "name": "act",
        "args": "r-1",
        "standing": Standing.PENDING,
    }
    return TreeNode(number=number, **{**values, **more})  # type: ignore[arg-type]


def drawn(*nodes: TreeNode, steps: tuple[TreeStep, ...] = ()) -> ET.Element:
    return ET.fromstring(draw_svg(GoalTree(nodes, steps)))


def of_class(root: ET.Element, name: str) -> list[ET.Element]:
    return [one for one in root.iter() if name in one.get("class", "").split()]


def test_goals_are_ovals_and_operators_boxes() -> None:
    root = drawn(goal(1), node(2, above=1))
    shapes = {one.get("id"): one.find("*[@class='shape']") for one in root.iter(f"{SVG}g")}
    assert shapes["n1"] is not None
    assert shapes["n1"].tag == f"{SVG}ellipse"
    assert shapes["n2"] is not None
    assert shapes["n2"].tag == f"{SVG}rect"


@pytest.mark.parametrize("standing", list(Standing))
def test_each_standing_is_drawn_in_its_own_way(standing: Standing) -> None:
    root = drawn(node(1, standing=standing))
    [group] = [one for one in root.iter(f"{SVG}g") if one.get("id") == "n1"]
    style = root.findtext(f"{SVG}style") or ""
    kind = group.get("class")
    assert kind == "pending" or f".{kind} .shape" in style


def test_the_tooltip_tells_rule_alternatives_and_failure() -> None:
    root = drawn(node(1, reason="nearest", over=tuple("abcdefghij"), note="no way"))
    [title] = [one.text or "" for one in root.iter(f"{SVG}title") if "n1" in (one.text or "")]
    assert "Chosen by: nearest." in title
    assert "Instead of: a; b; c; d; e; f; g; h and 2 more." in title
    assert "It failed: no way." in title


def test_a_shared_goal_that_is_near_is_linked_to_all_who_need_it() -> None:
    scene = compose(GoalTree((goal(1), node(2, above=1), goal(3, above=2, shared_by=(5,)),
                              goal(4), node(5, above=4))))  # fmt: skip
    assert [link.is_shared for link in scene.links].count(True) == 1
    assert not any(figure.is_reference for figure in scene.figures)


def test_a_shared_goal_that_is_far_is_referred_to() -> None:
    trees = [one for n in range(0, 60, 3) for one in (goal(n + 1), node(n + 2, above=n + 1))]
    scene = compose(GoalTree((*trees, goal(99, above=2, shared_by=(59,)))))
    [reference] = [figure for figure in scene.figures if figure.is_reference]
    assert reference.lines[-1] == "see n99"
    root = ET.fromstring(draw_svg(GoalTree((*trees, goal(99, above=2, shared_by=(59,))))))
    assert len([one for one in root.iter() if one.get("id") == "n99"]) == 1


def test_the_plan_stands_beneath_and_its_steps_bear_their_places() -> None:
    step = TreeStep(3, "<act r-1>", Standing.EXECUTED)
    root = drawn(node(2, standing=Standing.EXECUTED, applied=(1, 3)), steps=(step,))
    assert [one.text for one in of_class(root, "order")] == ["1"]
    assert [one.text for one in of_class(root, "number")] == ["n2 → n3"]
    assert any("<act r-1>  executed" in (one.text or "") for one in root.iter(f"{SVG}text"))


def test_of_many_failures_some_are_drawn_and_the_rest_counted() -> None:
    failed = [node(n, standing=Standing.FAILED, above=1) for n in range(2, 200)]
    root = drawn(goal(1), *failed)
    assert len(of_class(root, "failed")) == MOST_GONE + 1
    words = " ".join(one.text or "" for one in root.iter(f"{SVG}text"))
    assert f"{198 - MOST_GONE} more goals and operators are not drawn." in words


def test_an_empty_tree_is_a_drawing_too() -> None:
    assert "no step yet" in draw_svg(GoalTree())


@given(st.text(), st.text())
def test_any_name_makes_a_well_formed_drawing(name: str, args: str) -> None:
    step = TreeStep(2, name, Standing.DONE)
    one = node(1, name=name, args=args, note=args, reason=name, over=(args,), applied=(2,))
    root = ET.fromstring(draw_svg(GoalTree((one,), (step,), name), title=args))
    assert len([group for group in root.iter(f"{SVG}g") if group.get("id") == "n1"]) == 1


def test_the_drawing_is_as_large_as_what_is_in_it() -> None:
    wide = [goal(1), node(2, above=1), *(goal(n, above=2) for n in range(3, 40))]
    root = drawn(*wide)
    left, top, width, height = map(float, (root.get("viewBox") or "").split())
    assert (left, top) == (0.0, 0.0)
    scene = compose(GoalTree(tuple(wide)))
    assert width > scene.extent.width > 2000
    assert height > scene.extent.height


def test_the_pictures_of_the_documents_are_current(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DOCS)
    for name, draw in runpy.run_path(str(DOCS / "pictures.py"))["SETTLED"].items():
        assert (DOCS / name).read_text(encoding="utf-8") == draw(), "run docs/pictures.py"
