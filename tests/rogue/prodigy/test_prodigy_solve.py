"""Plans in other domains; limits; what has no plan; the command."""

from __future__ import annotations

from pathlib import Path

import pytest

import rogue.prodigy
from rogue.prodigy import (
    Literal,
    Mode,
    Problem,
    SearchOptions,
    SequenceError,
    Status,
    StepView,
    load_domain,
    load_problem,
    solve,
    validate_plan,
)

DOMAINS = Path(__file__).parent / "domains"

EXPECTED = {
    "blocks-stack": (Status.SOLVED, 6),
    "blocks-sussman": (Status.SOLVED, 6),
    "blocks-impossible": (Status.UNSOLVABLE, 0),
    "rockets-two": (Status.SOLVED, 5),
    "rockets-back": (Status.UNSOLVABLE, 0),
    "shop-pack": (Status.SOLVED, 4),
    "shop-paint": (Status.SOLVED, 3),
    "logistics-across": (Status.SOLVED, None),
}


def load(name: str) -> Problem:
    domain = load_domain(DOMAINS / f"{name.split('-', maxsplit=1)[0]}.pdl")
    return load_problem(DOMAINS / f"{name}.pdl", domain)


@pytest.mark.parametrize("mode", list(Mode))
@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_a_problem_ends_as_expected(name: str, mode: Mode) -> None:
    status, length = EXPECTED[name]
    problem = load(name)
    result = solve(problem, SearchOptions(mode=mode, max_nodes=4000))
    assert result.status is status
    if status is Status.SOLVED:
        assert validate_plan(problem, result.plan) is None
        assert length is None or len(result.plan) == length
        assert result.trace[-1] == "Achieved top-level goals."


def test_a_fault_in_a_plan_is_found() -> None:
    problem = load("blocks-stack")
    stack = StepView(1, "stack", ("a", "b"), (("<ob>", "a"), ("<under>", "b")))
    fault = validate_plan(problem, [stack])
    assert fault is not None
    assert (fault.step, fault.problem) == (0, "<STACK A B>: its precondition is false")
    missing = validate_plan(problem, [])
    assert missing is not None
    assert missing.problem == "the goal is not reached"


def test_limits_are_said_and_are_not_a_proof() -> None:
    problem = load("blocks-sussman")
    few = solve(problem, SearchOptions(max_nodes=10))
    assert (few.status, few.plan) == (Status.LIMIT, ())
    assert few.reason.startswith("gave up after 10 nodes")
    ticks = iter(range(100_000))
    slow = solve(problem, SearchOptions(time_limit=5.0, clock=lambda: float(next(ticks))))
    assert slow.status is Status.LIMIT
    assert slow.reason.startswith("gave up after 5 s")
    shallow = solve(problem, SearchOptions(depth_bound=12))
    assert shallow.status is Status.LIMIT
    assert any("hit depth bound (12)" in line for line in shallow.trace)


def test_a_hopeless_goal_is_proved_and_named() -> None:
    domain = load_domain(DOMAINS / "rockets.pdl")
    goal = Literal("has-fuel", ("apollo",))
    problem = Problem.build(domain, objects={"rocket": ["apollo"]}, goals=[goal])
    result = solve(problem)
    assert (result.status, result.hopeless) == (Status.UNSOLVABLE, (goal,))


def test_state_loops_and_goal_loops_are_printed() -> None:
    lines = solve(load("blocks-sussman"), SearchOptions(mode=Mode.SAVTA)).trace
    assert any("...goal loop with node" in line for line in lines)
    assert any(" [1]" in line for line in lines)


def test_levels_print_nothing_the_plan_nodes_or_rules() -> None:
    problem = load("shop-pack")
    silent, plan, nodes = (solve(problem, SearchOptions(level=level)).trace for level in range(3))
    assert silent == ()
    assert plan[0] == "Achieved top-level goals."
    assert [line.strip() for line in plan[1:]][-1] == "<PACK>"
    assert nodes[0] == "  2 n2 (done)"


def test_solve_does_not_execute() -> None:
    with pytest.raises(SequenceError):
        solve(load("shop-pack"), SearchOptions(execute=True))


def test_the_public_names_are_sorted_and_there() -> None:
    names = rogue.prodigy.__all__
    assert names == sorted(names)
    assert all(hasattr(rogue.prodigy, name) for name in names)
