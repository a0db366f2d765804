"""Several solutions, protection, the choice of nodes, and what level 3 prints."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rogue.prodigy import (
    Choice,
    LimitKind,
    Literal,
    Mode,
    NodeKind,
    NodeView,
    PreferRule,
    Problem,
    RuleSet,
    Search,
    SearchOptions,
    Solutions,
    Status,
    parse_domain,
    solutions,
    solve,
    validate_plan,
)


def independent(ways: list[int]) -> Problem:
    """One goal for each entry, with so many operators that reach it in one step."""
    texts = [
        f"(OPERATOR op{at}-{way} (params) (preconds () (and)) (effects () ((add (g{at})))))"
        for at, count in enumerate(ways)
        for way in range(count)
    ]
    goals = [Literal(f"g{at}") for at in range(len(ways))]
    return Problem.build(parse_domain("\n".join(texts)), objects={}, goals=goals)


def brute_force(ways: list[int]) -> set[tuple[str, ...]]:
    chosen = itertools.product(*(range(count) for count in ways))
    return {
        tuple(order)
        for choice in chosen
        for order in itertools.permutations([f"op{at}-{way}" for at, way in enumerate(choice)])
    }


@settings(max_examples=25, deadline=None)
@given(st.lists(st.integers(1, 2), min_size=1, max_size=3), st.sampled_from(Mode))
def test_all_solutions_are_those_of_brute_force(ways: list[int], mode: Mode) -> None:
    options = SearchOptions(mode=mode, solutions=Solutions.DIFFERENT, level=0)
    found = [tuple(s.operator for s in one.plan) for one in solutions(independent(ways), options)]
    assert len(found) == len(set(found))
    assert set(found) == brute_force(ways)


DETOURS = """
(OPERATOR walk (params) (preconds () (and (rested) (shod))) (effects () ((add (there)))))
(OPERATOR rest (params) (preconds () (and)) (effects () ((add (rested)))))
(OPERATOR dress (params) (preconds () (and)) (effects () ((add (shod)))))
(OPERATOR ride (params) (preconds () (saddled)) (effects () ((add (there)))))
(OPERATOR saddle (params) (preconds () (and)) (effects () ((add (saddled)))))
(OPERATOR fly (params) (preconds () (and)) (effects () ((add (there)))))
"""


def detours() -> Problem:
    return Problem.build(parse_domain(DETOURS), objects={}, goals=[Literal("there")])


def test_only_shorter_solutions_end_with_the_shortest() -> None:
    options = SearchOptions(solutions=Solutions.SHORTER)
    lengths = [len(one.plan) for one in solutions(detours(), options)]
    assert lengths == [3, 2, 1]
    result = solve(detours(), options)
    assert (result.status, result.solutions) == (Status.SOLVED, 3)
    assert [step.operator for step in result.plan] == ["fly"]
    assert "3 solutions were found" in result.reason


def test_a_limit_after_some_solutions_is_said() -> None:
    result = solve(detours(), SearchOptions(solutions=Solutions.ALL, max_nodes=20))
    assert result.status is Status.SOLVED
    assert result.limit is not None
    assert (result.limit.kind, result.limit.value) == (LimitKind.NODES, 20)
    assert result.solutions >= 1


CARPET = """
(OPERATOR drop (params) (preconds () (held))
  (effects () ((del (held)) (add (down)) (if (hard) ((del (whole)))))))
(OPERATOR lay (params) (preconds () (and)) (effects () ((del (hard)))))
"""


def carpet() -> Problem:
    facts = [Literal("held"), Literal("hard"), Literal("whole")]
    goals = [Literal("down"), Literal("whole")]
    return Problem.build(parse_domain(CARPET), objects={}, facts=facts, goals=goals)


@pytest.mark.parametrize("mode", list(Mode))
def test_protection_makes_a_harmful_condition_false_first(mode: Mode) -> None:
    problem = carpet()
    assert solve(problem, SearchOptions(mode=mode)).status is Status.LIMIT
    options = SearchOptions(mode=mode, protection=True)
    search = Search(problem, options)
    list(search.events())
    assert search.result is not None
    assert [step.operator for step in search.result.plan] == ["lay", "drop"]
    assert validate_plan(problem, search.result.plan) is None
    kept = next(node for node in search.nodes() if node.kind is NodeKind.PROTECTION)
    assert kept.text == "protect (whole) from <drop>"
    assert any(kept.text in line for line in search.trace)


def test_a_rule_may_ask_for_protection_before_anything_is_harmed() -> None:
    text = CARPET + "(CONTROL-RULE careful (if (applicable-operator <op>)) (then protect))"
    plain = carpet()
    problem = Problem.build(
        parse_domain(text),
        objects={},
        facts=plain.state.facts(),
        goals=[Literal("down"), Literal("whole")],
    )
    search = Search(problem, SearchOptions(level=3))
    list(search.events())
    assert search.result is not None
    assert [step.operator for step in search.result.plan] == ["lay", "drop"]
    assert "    Firing protect rule careful" in search.trace
    assert not any(node.failure for node in search.nodes())


def test_node_rules_take_part_in_choosing_the_next_node() -> None:
    def older(_view: object, one: object, other: object) -> bool:
        assert isinstance(one, NodeView)
        assert isinstance(other, NodeView)
        return one.number < other.number

    rules = RuleSet((PreferRule("breadth-first", Choice.NODE, older),))
    search = Search(detours(), SearchOptions(level=3), rules)
    list(search.events())
    assert search.result is not None
    assert [step.operator for step in search.result.plan] == ["fly"]
    decided = [d for d in search.decisions if d.choice is Choice.NODE]
    assert decided
    assert {d.reason for d in decided} == {"breadth-first"}
    assert any("Firing prefer nodes rule breadth-first to get (" in line for line in search.trace)


RULED = (
    DETOURS
    + """
(CONTROL-RULE ride-it (if (candidate-operator ride)) (then select operator ride))
(CONTROL-RULE never-wait (if (applicable-operator <op>)) (then apply))
"""
)


def test_level_3_names_the_rule_that_decided_before_the_node() -> None:
    problem = Problem.build(parse_domain(RULED), objects={}, goals=[Literal("there")])
    lines = solve(problem, SearchOptions(level=3)).trace
    rule = lines.index("    Firing select operators rule ride-it to get (ride)")
    assert lines[rule - 1] == "  5   n5 (there)"
    assert lines[rule + 1] == "  7   n7 <ride>"
