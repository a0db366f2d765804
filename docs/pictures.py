"""Draws the pictures of the documents: ``uv run python docs/pictures.py``."""

from __future__ import annotations

import json
from pathlib import Path

from recording_picture import draw_recording

from navigate.messages import Outlook
from navigate.view import draw_svg as draw_robot
from rogue.errands import Errand, figure9, load_office_problem
from rogue.explain import draw_svg
from rogue.prodigy import Execute, Search, goal_tree
from xavier_sim.messages import FloorPlan, WorldView

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


def navigator() -> str:
    """Figure 3 of the same paper, of a moment that was kept: people about, belief in two minds."""
    kept = json.loads((HERE / "navigate-moment.json").read_text(encoding="utf-8"))
    told, world = Outlook.model_validate(kept["navigator"]), WorldView.model_validate(kept["world"])
    return draw_robot(told, FloorPlan.model_validate(kept["map"]), world)


SETTLED = {"figure9.svg": figure_9, "navigate.svg": navigator}
"""Pictures that are the same until their drawing changes; tests hold them against the files."""

PICTURES = {**SETTLED, "recording.svg": draw_recording}
"""All of them; a recording is of a drive, and changes with how the robot drives."""

if __name__ == "__main__":
    for name, draw in PICTURES.items():
        (HERE / name).write_text(draw(), encoding="utf-8")
