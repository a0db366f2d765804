"""Draws the pictures of the documents: ``uv run python docs/pictures.py``."""

from __future__ import annotations

from pathlib import Path

from rogue.errands import Errand, figure9, load_office_problem
from rogue.explain import draw_svg
from rogue.prodigy import Execute, Search, goal_tree

HERE = Path(__file__).parent


def metres(one: str, other: str) -> float:
    """Metres between two rooms of the paper's corridor: odd rooms stand 3.6 m apart."""
    return abs(int(one[2:]) - int(other[2:])) * 1.8


def figure_9() -> str:
    """Figure 9 of Haigh & Veloso (1996): a second errand arrives while the robot drives."""
    office = figure9(metres)
    search = Search(load_office_problem("figure6", office.domain), office.options, office.rules)
    fax = Errand("jhm", "deliverfax", "r-5311", "r-5313")
    for event in search.events():
        if isinstance(event, Execute):
            if not search.executed_operators():
                search.add_goal(office.facts(fax), office.goal(fax))
            search.executed()
    return draw_svg(goal_tree(search), title="Two errands, the second while the robot drives")


PICTURES = {"figure9.svg": figure_9}

if __name__ == "__main__":
    for name, draw in PICTURES.items():
        (HERE / name).write_text(draw(), encoding="utf-8")
