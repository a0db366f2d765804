"""The goal tree tells how each goal and operator stands, at the end and on the way."""

from __future__ import annotations

from pathlib import Path

from prodigy_office_runs import (
    JHM,
    arrives_during_first_step,
    figure6_search,
    metres,
    run,
    wrong_room_first,
)

from rogue.errands import Agenda, figure9, working
from rogue.prodigy import (
    Execute,
    Search,
    SearchOptions,
    Standing,
    TreeNode,
    goal_tree,
    load_domain,
    load_problem,
    render_tree,
)

DOMAINS = Path(__file__).parent / "domains"

FIGURE9 = """\
n5 (has-item mitchell delivermail) done
└─ n7 <deliver-item r-5313 mitchell delivermail> executed as n33
   ├─ n8 (robot-has-item mitchell delivermail) done
   │  └─ n10 <acquire-item r-5303 mitchell delivermail> executed as n19
   │     └─ n11 (robot-in-room r-5303) done
   │        └─ n13 <goto-pickup-loc mitchell r-5303> executed as n18
   └─ n14 (robot-in-room r-5313) done
      ├─ n15 <goto-pickup-loc> failed: no choices for bindings (I tried)
      └─ n17 <goto-deliver-loc mitchell r-5313> executed as n31
n20 (has-item jhm deliverfax) done
└─ n22 <deliver-item r-5313 jhm deliverfax> executed as n32
   ├─ (robot-in-room r-5313), see n14
   └─ n23 (robot-has-item jhm deliverfax) done
      └─ n25 <acquire-item r-5311 jhm deliverfax> executed as n30
         └─ n26 (robot-in-room r-5311) done
            └─ n28 <goto-pickup-loc jhm r-5311> executed as n29

Solution:
  1 <goto-pickup-loc mitchell r-5303> executed
  2 <acquire-item r-5303 mitchell delivermail> executed
  3 <goto-pickup-loc jhm r-5311> executed
  4 <acquire-item r-5311 jhm deliverfax> executed
  5 <goto-deliver-loc mitchell r-5313> executed
  6 <deliver-item r-5313 jhm deliverfax> executed
  7 <deliver-item r-5313 mitchell delivermail> executed"""


def by_number(search: Search) -> dict[int, TreeNode]:
    return {node.number: node for node in goal_tree(search).nodes}


def load(name: str) -> Search:
    domain = load_domain(DOMAINS / f"{name.split('-', maxsplit=1)[0]}.pdl")
    return Search(load_problem(DOMAINS / f"{name}.pdl", domain), SearchOptions())


def test_figure_9_as_text() -> None:
    search = run(figure6_search(figure9(metres)), outcome=arrives_during_first_step(JHM))
    assert render_tree(goal_tree(search)) == FIGURE9


def test_a_running_search_shows_what_is_executing_and_what_is_pending() -> None:
    search = figure6_search(figure9(metres))
    next(event for event in search.events() if isinstance(event, Execute))
    nodes = by_number(search)
    assert nodes[13].standing is Standing.RUNNING
    assert nodes[13].applied == (18,)
    assert {nodes[n].standing for n in (5, 7, 8, 10, 11, 14, 17)} == {Standing.PENDING}
    assert goal_tree(search).status == ""
    search.executed()
    assert by_number(search)[13].standing is Standing.EXECUTED
    assert [step.number for step in goal_tree(search).steps] == [18]


def test_a_goal_that_was_missed_is_there_again() -> None:
    search = run(figure6_search(figure9(metres)), outcome=wrong_room_first("r-5305"))
    nodes = by_number(search)
    assert nodes[19].name == nodes[11].name == "robot-in-room"
    assert nodes[19].above == nodes[11].above == 10
    assert nodes[21].applied == (22,)


def test_the_rule_that_decided_stands_at_what_it_chose() -> None:
    search = run(figure6_search(working(Agenda.plain(metres))))
    rules = {node.reason for node in goal_tree(search).nodes if not node.is_goal}
    assert "pickup-goto-for-acquire" in rules


def test_what_backtracking_left_behind_is_given_up() -> None:
    search = load("blocks-sussman")
    list(search.events())
    tree = goal_tree(search)
    standings = {node.standing for node in tree.nodes}
    assert {Standing.DONE, Standing.FAILED, Standing.DROPPED} == standings
    applied = {number for node in tree.nodes for number in node.applied}
    assert {step.number for step in tree.steps} <= applied
    done = [n for n in tree.nodes if not n.is_goal and n.standing is Standing.DONE]
    assert len(done) == len(tree.steps)


def test_the_tree_of_a_search_that_has_not_begun_is_empty() -> None:
    assert render_tree(goal_tree(load("shop-pack"))) == ""
