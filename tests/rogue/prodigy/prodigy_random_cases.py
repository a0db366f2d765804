"""Random small domains and problems, as data and in PRODIGY's language."""

from __future__ import annotations

from dataclasses import dataclass

from hypothesis import strategies as st

from rogue.prodigy import Problem, parse_domain, parse_problem

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
