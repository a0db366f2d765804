"""What situations keep up to date, against working it out anew from its definition."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from prodigy_random_domains import MADE, OBJECTS, Texts, reachable, texts

from rogue.prodigy import Execute, Literal, Mode, Poll, Search, SearchOptions, Status, solve
from rogue.prodigy._nodes import Node
from rogue.prodigy._situation import Situation


def live(situation: Situation) -> set[Node]:
    """The operators to which a chain of false goals leads from *finish*."""
    servers = {
        node.goal: node
        for node in situation.tail.values()
        if node.goal is not None and situation.expanded.get(node.goal) is node.goal_node
    }
    found: set[Node] = set()
    agenda = [situation.finish] if situation.finish is not None else []
    while agenda:
        node = agenda.pop()
        if node in found:
            continue
        found.add(node)
        lacking = situation.lacks(node)
        agenda += [servers[goal] for goal in lacking if goal in servers]
    return found


def check(situation: Situation) -> None:
    alive = live(situation)
    holds = situation.state.holds
    for number, node in situation.tail.items():
        assert situation.lacking[number] == len(situation.lacks(node))
        assert (number in situation.free) == (not situation.lacks(node))
        assert situation.view.is_live(node) == (node in alive)
    assert not any(holds(goal) for goal in situation.expanded)
    newest = sorted(alive, key=lambda node: -node.number)
    pending: dict[Literal, list[Node]] = {}
    for node in newest:
        for goal in situation.lacks(node):
            if goal not in situation.expanded:
                pending.setdefault(goal, []).append(node)
    known = {goal: list(nodes) for goal, nodes in situation.view.pending().items()}
    assert list(known.items()) == list(pending.items())
    ready = [n for n in newest if n.is_applicable() and not situation.lacks(n)]
    assert situation.view.ready() == ready


@settings(max_examples=40, deadline=None)
@given(texts, st.sampled_from(Mode), st.integers(0, 1000))
def test_situations_are_what_they_would_be_if_worked_out_anew(
    case: Texts, mode: Mode, seed: int
) -> None:
    chance = random.Random(seed)
    facts = [Literal(name, (thing,)) for name in MADE for thing in OBJECTS]
    options = SearchOptions(mode=mode, execute=True, max_nodes=250, proof_states=200)
    search = Search(case.problem(), options)
    for event in search.events():
        check(search._engine.current())
        if isinstance(event, Execute):
            if chance.random() < 0.3:
                search.executed(added=[chance.choice(facts)], deleted=[])
            else:
                search.executed()
            check(search._engine.current())
        elif isinstance(event, Poll) and chance.random() < 0.05:
            fact = chance.choice(facts)
            (search.assert_facts if chance.random() < 0.5 else search.retract_facts)(fact)
            if chance.random() < 0.3:
                search.add_goal((), chance.choice(facts))
    assert search.result is not None


@settings(max_examples=15, deadline=None)
@given(texts)
def test_both_modes_agree_whether_there_is_a_plan(case: Texts) -> None:
    problem = case.problem()
    options = {mode: SearchOptions(mode=mode, max_nodes=600, level=0) for mode in Mode}
    results = {mode: solve(problem, options[mode]) for mode in Mode}
    decided = {r.status for r in results.values() if r.status is not Status.LIMIT}
    assert len(decided) <= 1
    for result in results.values():
        if result.status is Status.UNSOLVABLE:
            assert not reachable(problem)
        elif result.status is Status.LIMIT:
            assert result.limit is not None


@pytest.mark.parametrize("mode", list(Mode))
def test_a_snapshot_survives_that_old_history_is_let_go(mode: Mode) -> None:
    case = Texts(
        operators=(
            "(and)) (effects () ((add (p <x>)) (del (q <x>))))"
            .replace("(and))", "(q <x>))"),
            "(and)) (effects () ((add (q <x>)) (del (p <x>))))",
        ),
        rules=("(and (p <x>) (r <x>))", "(r <x>)", "(r <y>)"),
        start=(),
        goal=("(p a)",),
    )  # fmt: skip
    search = Search(
        case.problem(),
        SearchOptions(mode=mode, execute=True, max_held=60, max_nodes=None, depth_bound=None),
    )
    steps = 0
    for event in search.events():
        if isinstance(event, Execute):
            steps += 1
            search.executed()
            check(search._engine.current())
            if steps < 60:
                search.retract_facts(Literal("p", ("a",)))
        snapshot = search.snapshot()
        numbers = {node.number for node in snapshot.nodes}
        assert snapshot.current in numbers
        assert snapshot.barrier in numbers
    assert steps >= 60
    assert len(search.nodes()) <= 60
