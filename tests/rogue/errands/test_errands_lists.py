"""The lists that the 1998 example has at its steps."""

from __future__ import annotations

from itertools import pairwise

from rogue.errands import Errand, Lists, ListWatcher, Moment, example1998, load_office_problem
from rogue.prodigy import Execute, Search

PG_MITCHELL = "PG is (has-item mitchell delivermail)"
PG_JHM = "PG is (has-item jhm deliverfax)"
DELIVER = "(GOTO-DELIVER-LOC mitchell r-5313)"
PICKUP = "(GOTO-PICKUP-LOC mitchell r-5303)"
ACQUIRE = "(ACQUIRE-ITEM r-5303 mitchell delivermail)"
PICKUP_JHM = "(GOTO-PICKUP-LOC jhm r-5311)"
ACQUIRE_JHM = "(ACQUIRE-ITEM r-5311 jhm deliverfax)"
INDENT = " " * 16

STEPS = {
    (4, "planned"): [PG_MITCHELL, "Applicable-Ops is nil", "Executed-Ops is nil"],
    (7, "planned"): [
        "PG is (and (robot-has-item mitchell delivermail) (robot-in-room r-5313))",
        "Applicable-Ops is nil",
        "Executed-Ops is nil",
    ],
    (16, "planned"): [
        "PG is nil",
        f"Applicable-Ops is (and {DELIVER} {PICKUP})",
        "Executed-Ops is nil",
    ],
    (17, "executing"): ["PG is nil", f"Applicable-Ops is {DELIVER}", "Executed-Ops is nil"],
    (0, "goals changed"): [PG_JHM, f"Applicable-Ops is {DELIVER}", "Executed-Ops is nil"],
    (17, "executed"): [
        PG_JHM,
        f"Applicable-Ops is (and {DELIVER} {ACQUIRE})",
        f"Executed-Ops is {PICKUP}",
    ],
    (26, "planned"): [
        "PG is nil",
        f"Applicable-Ops is (and {DELIVER} {ACQUIRE} {PICKUP_JHM})",
        f"Executed-Ops is {PICKUP}",
    ],
    (27, "executed"): [
        "PG is nil",
        f"Applicable-Ops is (and {DELIVER} {PICKUP_JHM})",
        f"Executed-Ops is {PICKUP}",
        f"{INDENT}{ACQUIRE}",
    ],
    (28, "executed"): [
        "PG is nil",
        f"Applicable-Ops is (and {DELIVER} {ACQUIRE_JHM})",
        f"Executed-Ops is {PICKUP}",
        f"{INDENT}{ACQUIRE}",
        f"{INDENT}{PICKUP_JHM}",
    ],
}
"""Lists by node and what happened to it: steps 1 to 9."""


def metres(one: str, other: str) -> float:
    return abs(int(one[2:]) - int(other[2:])) * 1.8


def moments() -> list[Moment]:
    switches = example1998(metres)
    search = Search(
        load_office_problem("figure6", switches.domain), switches.options, switches.rules
    )
    jhm = Errand("jhm", "deliverfax", "r-5311", "r-5313")
    chronicle, found = ListWatcher(), list[Moment | None]()
    for event in search.events():
        found.append(chronicle.observe(search, event))
        if isinstance(event, Execute):
            if event.node.number == 17:
                search.add_goal(switches.facts(jhm), switches.goal(jhm))
                found.append(chronicle.goals_changed(search))
            search.executed()
    return [moment for moment in found if moment is not None]


def test_the_lists_are_those_of_the_paper():
    seen = {(m.node, m.what): m.lists.lines() for m in moments()}
    assert {step: seen.get(step) for step in STEPS} == STEPS


def test_a_moment_is_told_only_when_a_list_has_changed():
    told = [m.lists for m in moments()]
    assert all(one != other for one, other in pairwise(told))
    assert isinstance(told[0], Lists)
