"""The search tree looked at while it runs."""

from __future__ import annotations

from prodigy_office_runs import figure6_search, metres, run

from rogue.errands import example1998, figure6
from rogue.prodigy import Execute, NodeKind, NodeState, Search, TreeSnapshot


def by_number(snapshot: TreeSnapshot) -> dict[int, tuple[str, NodeState]]:
    return {node.number: (node.text, node.state) for node in snapshot.nodes}


def at_second_step(search: Search) -> TreeSnapshot:
    for event in search.events():
        if isinstance(event, Execute):
            if search.executed_operators():
                return search.snapshot()
            search.executed()
    raise AssertionError("two steps are executed")


def test_a_snapshot_shows_what_has_become_of_each_node() -> None:
    snapshot = at_second_step(figure6_search(figure6()))
    nodes = by_number(snapshot)
    assert nodes[15] == ("goto-pickup-loc", NodeState.FAILED)
    assert nodes[18] == ("<GOTO-PICKUP-LOC MITCHELL R-5303>", NodeState.EXECUTED)
    assert nodes[19] == ("<ACQUIRE-ITEM R-5303 MITCHELL DELIVERMAIL>", NodeState.APPLIED)
    assert nodes[5][1] is NodeState.CLOSED
    assert (snapshot.current, snapshot.barrier) == (19, 18)
    assert snapshot.path == (*range(1, 15), 16, 17, 18, 19)


def test_a_snapshot_has_the_links_of_the_goal_tree() -> None:
    search = run(figure6_search(example1998(metres)))
    nodes = {node.number: node for node in search.snapshot().nodes}
    assert nodes[11].kind is NodeKind.GOAL
    assert nodes[11].needed_by == (10,)
    assert (nodes[13].serves, nodes[13].parent) == (11, 12)
    assert (nodes[17].applies, nodes[17].serves) == (13, 11)
    assert nodes[15].decided_by == "goto-for-consumer"
    assert nodes[16].state is NodeState.CLOSED


def test_a_snapshot_does_not_change_with_the_search() -> None:
    search = figure6_search(figure6())
    search.step()
    before = search.snapshot()
    copy = by_number(before)
    run(search)
    assert by_number(before) == copy
    assert len(search.snapshot().nodes) > len(before.nodes)
