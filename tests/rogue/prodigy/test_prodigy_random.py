"""Random small domains: plans are valid, and what is called unsolvable is so."""

from __future__ import annotations

import itertools

from hypothesis import given, settings
from hypothesis import strategies as st
from prodigy_random_cases import OBJECTS, Case, Fact, Step, as_problem, cases

from rogue.prodigy import (
    Mode,
    PdlError,
    SearchOptions,
    Status,
    parse_domain,
    solve,
    validate_plan,
)


def reachable(case: Case) -> bool:
    """Look at every state in reach, from the data and not from the texts."""
    seen, agenda = {case.start}, [case.start]
    while agenda:
        state = agenda.pop()
        if all(((name, thing) in state) == sign for name, thing, sign in case.goal):
            return True
        for step, x, y in itertools.product(case.steps, OBJECTS, OBJECTS):
            after = applied(step, state, {"<x>": x, "<y>": y})
            if after is not None and after not in seen:
                seen.add(after)
                agenda.append(after)
    return False


def applied(step: Step, state: frozenset[Fact], values: dict[str, str]) -> frozenset[Fact] | None:
    if any(((name, values[v]) in state) != sign for name, v, sign in step.needs):
        return None
    gone = {(name, values[v]) for name, v, _ in step.deletes}
    return (state - gone) | {(name, values[v]) for name, v, _ in step.adds}


@settings(max_examples=80, deadline=None)
@given(cases, st.sampled_from(Mode))
def test_plans_are_valid_and_unsolvable_is_true(case: Case, mode: Mode) -> None:
    problem = as_problem(case)
    result = solve(problem, SearchOptions(mode=mode, max_nodes=1500, level=0))
    if result.status is Status.SOLVED:
        assert validate_plan(problem, result.plan) is None
        assert reachable(case)
    elif result.status is Status.UNSOLVABLE:
        assert not reachable(case)
    else:
        assert result.status is Status.LIMIT
        assert reachable(case), "so small a problem is solved or proved unsolvable"


@settings(max_examples=60, deadline=None)
@given(st.text(alphabet="()<>xyz~ \n;\"#|'", max_size=60))
def test_any_text_is_read_or_refused_with_a_place(text: str) -> None:
    place = 1
    try:
        parse_domain(text)
    except PdlError as error:
        place = error.position.line
    assert place >= 1
