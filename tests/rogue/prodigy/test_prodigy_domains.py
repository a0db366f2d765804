"""Problems of many kinds, in both modes and both languages, against what is known of them."""

from __future__ import annotations

from dataclasses import replace

import pytest
from prodigy_problems import DOMAINS, EXPECTED, load_named, shortest

from rogue.prodigy import (
    Mode,
    Problem,
    RuleSet,
    Search,
    SearchOptions,
    SearchResult,
    Solutions,
    Status,
    solve,
    validate_plan,
)

MODES = list(Mode)
NODES, FEW_NODES, STATES = 4000, 1500, 2000
TWINS = sorted(path.stem for path in DOMAINS.glob("*-*.pddl"))
NOT_ALL = {"machining", "meetings", "fleet-three"}
"""Domains with numbers and problems with too many states to look at every one."""


def names(key: str) -> list[str]:
    return [name for name, known in EXPECTED.items() if key in known]


def searched(problem: Problem, mode: Mode, nodes: int = NODES) -> SearchResult:
    options = SearchOptions(mode=mode, max_nodes=nodes, proof_states=STATES, level=0)
    return solve(problem, options)


def test_every_problem_has_its_expectation() -> None:
    files = {path.stem for path in DOMAINS.glob("*-*.pdl")}
    assert files == set(EXPECTED)
    assert set(TWINS) < files
    assert len({name.partition("-")[0] for name in files}) >= 14


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", EXPECTED)
def test_a_problem_ends_as_expected(name: str, mode: Mode) -> None:
    known, problem = EXPECTED[name], load_named(name).problem
    if mode in known.get("gives_up", []):
        assert searched(problem, mode, FEW_NODES).status is Status.LIMIT
        return
    result = searched(problem, mode)
    assert result.status == known["status"]
    if result.status is Status.SOLVED:
        assert validate_plan(problem, result.plan) is None
        assert len(result.plan) >= known.get("shortest", 0)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", names("nodes"))
def test_a_straight_search_makes_no_node_too_many(name: str, mode: Mode) -> None:
    search = Search(load_named(name).problem, SearchOptions(mode=mode, level=0))
    *_, _ = search.events()
    assert search.result is not None
    assert (search.result.status, search.result.nodes) == (Status.SOLVED, EXPECTED[name]["nodes"])


@pytest.mark.parametrize(
    "name", [name for name in EXPECTED if not {name, name.partition("-")[0]} & NOT_ALL]
)
def test_what_is_known_is_so(name: str) -> None:
    known = EXPECTED[name]
    assert shortest(load_named(name).problem) == known.get("shortest")
    assert ("shortest" in known) == (known["status"] == "solved")


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", names("without_rules"))
def test_without_its_rules_a_search_is_lost(name: str, mode: Mode) -> None:
    problem = load_named(name).problem
    bare = replace(problem, domain=replace(problem.domain, rules=RuleSet()))
    assert searched(bare, mode, FEW_NODES).status == EXPECTED[name]["without_rules"]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", names("protection"))
def test_protection_finds_what_a_conditional_effect_hides(name: str, mode: Mode) -> None:
    problem = load_named(name).problem
    result = solve(problem, SearchOptions(mode=mode, protection=True, level=0))
    assert result.status is Status.SOLVED
    assert validate_plan(problem, result.plan) is None


@pytest.mark.parametrize(
    ("name", "mode"),
    [(name, mode) for name in names("shorter") for mode in EXPECTED[name]["shorter"]],
)
def test_a_search_for_shorter_plans_comes_to_the_shortest(name: str, mode: str) -> None:
    options = SearchOptions(mode=Mode(mode), max_nodes=NODES, level=0, solutions=Solutions.SHORTER)
    problem = load_named(name).problem
    result = solve(problem, options)
    assert len(result.plan) == EXPECTED[name]["shortest"]
    assert validate_plan(problem, result.plan) is None


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("name", TWINS)
def test_a_problem_in_pddl_is_searched_as_its_twin(name: str, mode: Mode) -> None:
    ours, theirs = (load_named(name, language).problem for language in ("pdl", "pddl"))
    first, second = searched(ours, mode), searched(theirs, mode)
    assert (first.status, first.nodes) == (second.status, second.nodes)
    assert [s.operator for s in first.plan] == [s.operator for s in second.plan]
    assert first.status is not Status.SOLVED or validate_plan(theirs, second.plan) is None


def test_all_values_of_an_effects_variable_are_changed() -> None:
    problem = load_named("briefcase-all").problem
    result = searched(problem, Mode.SABA)
    carries = [step for step in result.plan if step.operator == "carry"]
    assert carries
    assert all({name for name, _ in step.bindings} == {"<from>", "<to>"} for step in carries)


def test_no_proof_overlooks_numbers_that_only_facts_give() -> None:
    problem = load_named("machining-axle").problem
    few = solve(problem, SearchOptions(max_nodes=10, level=0))
    assert (few.status, few.reason) == (Status.LIMIT, "gave up after 10 nodes; there is a plan")
