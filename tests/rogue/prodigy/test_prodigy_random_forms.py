"""Random domains with quantifiers, functions and conditional effects: outcomes are right."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st
from prodigy_writing import domain_text
from test_prodigy_reading import ARITIES, TREE, domains, expressions, facts

from rogue.prodigy import (
    Domain,
    Literal,
    Mode,
    Objects,
    Problem,
    SearchOptions,
    State,
    Status,
    parse_domain,
    solve,
    validate_plan,
)
from rogue.prodigy._expressions import Expression
from rogue.prodigy._simulate import after, cases, holds, start

OBJECTS = Objects(TREE, {"rex": "puppy", "tom": "cat"})
EVERYTHING = "(and (owns rex rex) (eats rex rex) (happy rex) (raining))"
NEVER = f"(operator never (preconds () {EVERYTHING}) (effects () ()))"
MOST_STATES = 300


def is_reachable(problem: Problem) -> bool | None:
    """Look at every state in reach; None if there are too many."""
    begin = start(problem)
    seen, agenda = {begin}, [begin]
    while agenda:
        world = agenda.pop()
        if holds(problem, world.facts, problem.goal, {}):
            return True
        for operator in problem.domain.operators:
            for case in cases(problem, world.facts, operator.variables, {}):
                if holds(problem, world.facts, operator.precondition, case):
                    reached = after(problem, world, operator, case)
                    if reached not in seen:
                        seen.add(reached)
                        agenda.append(reached)
        if len(seen) > MOST_STATES:
            return None
    return False


@settings(max_examples=60, deadline=None)
@given(domains(), st.lists(facts, max_size=5), expressions((), 1), st.sampled_from(Mode))
def test_plans_are_valid_and_what_is_called_unsolvable_is_so(
    made: Domain, true: list[Literal], goal: Expression, mode: Mode
) -> None:
    plain = Domain(made.name, made.types, made.operators, ARITIES)
    domain = parse_domain(domain_text(plain) + NEVER)
    here = [f for f in true if all(arg in OBJECTS or arg == 3 for arg in f.args)]
    problem = Problem(domain, "random", OBJECTS, State(here), goal)
    result = solve(problem, SearchOptions(mode=mode, max_nodes=300, proof_states=300))
    if result.status is Status.SOLVED:
        assert validate_plan(problem, result.plan) is None
    elif result.status is Status.UNSOLVABLE:
        assert not is_reachable(problem)
