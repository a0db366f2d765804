"""Random small domains with all that the language has, and what can be reached in them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from hypothesis import strategies as st

from rogue.prodigy import Problem, StepView, parse_domain, parse_problem
from rogue.prodigy._simulate import SimulatedWorld, after, cases, holds, start

OBJECTS = ("a", "b")
MADE = ("p", "q", "r")
"""Predicates that operators change."""
INFERRED = ("e", "l", "m")
"""Predicates that only an eager rule, or one of two lazy rules, infers."""

variables = st.sampled_from(("<x>", "<y>"))
made = st.builds(lambda name, v: f"({name} {v})", st.sampled_from(MADE), variables)
asked = st.builds(lambda name, v: f"({name} {v})", st.sampled_from(MADE + INFERRED), variables)


def negation(text: str) -> str:
    return f"(~ {text})"


def joined(word: str, items: list[str]) -> str:
    return f"({word} {' '.join(items)})" if items else "(and)"


literals = st.one_of(asked, asked, made.map(negation), asked.map(negation))
quantified = st.builds(
    lambda word, name, sign: f"({word} ((<z> thing)) {sign(f'({name} <z>)')})",
    st.sampled_from(("forall", "exists")),
    st.sampled_from(MADE + INFERRED),
    st.sampled_from((str, negation)),
)
parts = st.one_of(
    literals, literals, quantified, st.lists(literals, min_size=2, max_size=2).map(
        lambda items: joined("or", items)
    )
)  # fmt: skip
conditions = st.lists(parts, min_size=1, max_size=2).map(lambda items: joined("and", items))
changes = st.builds(
    lambda word, fact: f"({word} {fact})", st.sampled_from(("add", "add", "del")), made
)
conditional = st.builds(lambda test, change: f"(if {test} ({change}))", literals, changes)
universal = st.builds(
    lambda test, word, name: f"(forall ((<z> thing)) {test} (({word} ({name} <z>))))",
    literals,
    st.sampled_from(("add", "del")),
    st.sampled_from(MADE),
)
effects = st.lists(st.one_of(changes, changes, conditional, universal), min_size=1, max_size=3)


@st.composite
def operators(draw: st.DrawFn) -> str:
    return f"{draw(conditions)})\n (effects () ({' '.join(draw(effects))}))"


@st.composite
def rules(draw: st.DrawFn) -> tuple[str, str, str]:
    """Conditions of an eager rule and of two lazy ones, the second resting on the first."""
    eager = st.lists(st.one_of(made, made.map(negation)), min_size=1, max_size=2)
    lower = st.lists(st.one_of(made, made.map(negation), st.just("(e <x>)")), max_size=2)
    upper = st.lists(st.one_of(made, st.just("(l <x>)"), st.just("(m <y>)")), max_size=2)
    return tuple(joined("and", draw(some)) for some in (eager, lower, upper))  # type: ignore[return-value]


goals = st.lists(
    st.builds(
        lambda name, thing, sign: sign(f"({name} {thing})"),
        st.sampled_from(MADE + INFERRED),
        st.sampled_from(OBJECTS),
        st.sampled_from((str, str, str, negation)),
    ),
    min_size=2,
    max_size=4,
    unique=True,
)
starts = st.lists(
    st.builds(lambda n, o: f"({n} {o})", st.sampled_from(MADE), st.sampled_from(OBJECTS)),
    max_size=2,
)


@dataclass(frozen=True)
class Texts:
    """A domain and a problem of it, as texts."""

    operators: tuple[str, ...]
    rules: tuple[str, str, str]
    start: tuple[str, ...]
    goal: tuple[str, ...]

    def problem(self) -> Problem:
        lines = ["(ptype-of thing :top-type)"]
        lines += [
            f"(OPERATOR step{at} (params <x> <y>) (preconds ((<x> thing) (<y> thing)) {text})"
            for at, text in enumerate(self.operators)
        ]
        modes = zip(INFERRED, self.rules, ("eager", "lazy", "lazy"), strict=True)
        lines += [
            f"(INFERENCE-RULE says-{name} (mode {mode}) (params <x> <y>)"
            f" (preconds ((<x> thing) (<y> thing)) {test}) (effects () ((add ({name} <x>)))))"
            for name, test, mode in modes
        ]
        state, goal = " ".join(self.start), " ".join(self.goal)
        known = " ".join(f"({name} <x>)" for name in MADE + INFERRED)
        lines.append(
            f"(OPERATOR never (preconds ((<x> thing)) (and (never) {known})) (effects () ()))"
        )
        text = f"(create-problem (objects (a b thing)) (state (and {state})) (goal (and {goal})))"
        return parse_problem(text, parse_domain("\n".join(lines)))


texts = st.builds(
    Texts,
    st.lists(operators(), min_size=4, max_size=6).map(tuple),
    rules(),
    starts.map(tuple),
    goals.map(tuple),
)


def is_goal(problem: Problem, world: SimulatedWorld) -> bool:
    found = cases(problem, world.facts, problem.variables, {})
    return any(holds(problem, world.facts, problem.goal, case) for case in found)


def successors(
    problem: Problem, world: SimulatedWorld
) -> Iterator[tuple[StepView, SimulatedWorld]]:
    for operator in problem.domain.operators:
        for case in cases(problem, world.facts, operator.variables, {}):
            if holds(problem, world.facts, operator.precondition, case):
                args = tuple(case[name] for name in operator.params)
                step = StepView(0, operator.name, args, tuple(sorted(case.items())))
                yield step, after(problem, world, operator, case)


def reachable(problem: Problem) -> bool:
    """Look at every state in reach, with the independent simulation."""
    first = start(problem)
    seen, agenda = {first}, deque([first])
    while agenda:
        world = agenda.popleft()
        if is_goal(problem, world):
            return True
        for _, then in successors(problem, world):
            if then not in seen:
                seen.add(then)
                agenda.append(then)
    return False
