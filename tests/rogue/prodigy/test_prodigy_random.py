"""Random small domains: plans are valid, and what is called unsolvable is so."""

from __future__ import annotations

import itertools
from dataclasses import dataclass

from hypothesis import given, settings
from hypothesis import strategies as st

from rogue.prodigy import (
    Mode,
    PdlError,
    Problem,
    SearchOptions,
    Status,
    parse_domain,
    parse_problem,
    solve,
    validate_plan,
)

OBJECTS = ("a", "b")
PREDICATES = ("p", "q", "r")
Fact = tuple[str, str]
Pattern = tuple[str, str, bool]


@dataclass(frozen=True)
class Step:
    """One operator over the variables <x> and <y>."""

    needs: tuple[Pattern, ...]
    adds: tuple[Pattern, ...]
    deletes: tuple[Pattern, ...]


@dataclass(frozen=True)
class Case:
    steps: tuple[Step, ...]
    start: frozenset[Fact]
    goal: tuple[Pattern, ...]


variables = st.sampled_from(("<x>", "<y>"))
signed = st.tuples(st.sampled_from(PREDICATES), variables, st.booleans())
plain = st.tuples(st.sampled_from(PREDICATES), variables, st.just(True))
steps = st.builds(
    Step,
    st.lists(signed, max_size=3).map(tuple),
    st.lists(plain, max_size=2).map(tuple),
    st.lists(plain, max_size=2).map(tuple),
)
facts = st.tuples(st.sampled_from(PREDICATES), st.sampled_from(OBJECTS))
goals = st.tuples(st.sampled_from(PREDICATES), st.sampled_from(OBJECTS), st.booleans())
cases = st.builds(
    Case,
    st.lists(steps, min_size=1, max_size=3).map(tuple),
    st.frozensets(facts, max_size=4),
    st.lists(goals, min_size=1, max_size=3).map(tuple),
)


def literal(pattern: Pattern) -> str:
    text = f"({pattern[0]} {pattern[1]})"
    return text if pattern[2] else f"(~ {text})"


def as_problem(case: Case) -> Problem:
    known = " ".join(f"({name} <x>)" for name in PREDICATES)
    texts = [
        "(ptype-of thing :top-type)",
        f"(OPERATOR never (preconds ((<x> thing)) (and (never) {known})) (effects () ()))",
    ]
    for at, step in enumerate(case.steps):
        needs = " ".join(map(literal, step.needs))
        adds = " ".join(f"(add {literal(a)})" for a in step.adds)
        deletes = " ".join(f"(del {literal(d)})" for d in step.deletes)
        texts.append(
            f"(OPERATOR step{at} (params <x> <y>) (preconds ((<x> thing) (<y> thing))"
            f" (and {needs})) (effects () ({adds} {deletes})))"
        )
    state = " ".join(f"({name} {thing})" for name, thing in sorted(case.start))
    goal = " ".join(map(literal, case.goal))
    text = f"(create-problem (objects (a b thing)) (state (and {state})) (goal (and {goal})))"
    return parse_problem(text, parse_domain("\n".join(texts)))


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
