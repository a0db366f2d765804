"""Whatever is searched, in whatever domain, can be drawn, printed and told."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from prodigy_problems import DOMAINS, load_named

from rogue.explain import Chronicle, draw_svg, sentence
from rogue.prodigy import (
    Decided,
    Failed,
    Mode,
    Search,
    SearchOptions,
    Standing,
    goal_tree,
    render_tree,
)

PROBLEMS = sorted(path for path in DOMAINS.glob("*.pdl") if "-" in path.stem)


@pytest.mark.parametrize("path", PROBLEMS, ids=lambda path: path.stem)
def test_any_search_can_be_drawn_printed_and_told(path: Path) -> None:
    problem = load_named(path.stem).problem
    search = Search(problem, SearchOptions(mode=Mode.SAVTA, max_nodes=150))
    chronicle, said = Chronicle(), []
    for event in search.events():
        if isinstance(event, Decided | Failed):
            said += [sentence(decision) for decision in chronicle.note(event, 1.0)]
    assert said == []
    tree = goal_tree(search)
    numbers = [node.number for node in tree.nodes]
    assert numbers == sorted(set(numbers))
    assert all(node.above == 0 or node.above in numbers for node in tree.nodes)
    assert all(node.above < node.number for node in tree.nodes)
    assert all(set(node.shared_by) <= {*numbers} - {node.above} for node in tree.nodes)
    printed = render_tree(tree)
    assert all(f"n{number} " in printed for number in numbers)
    root = ET.fromstring(draw_svg(tree))
    ids = [one.get("id") for one in root.iter() if one.get("id")]
    assert len(ids) == len(set(ids))
    live = [n for n in tree.nodes if n.standing not in {Standing.FAILED, Standing.DROPPED}]
    assert {f"n{node.number}" for node in live} <= set(ids)
