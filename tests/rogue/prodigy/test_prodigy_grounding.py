"""Facts are found by their arguments, variables get their values; as slow enumeration says."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_prodigy_reading import CONSTANTS, TREE, expressions

from rogue.prodigy import (
    Domain,
    Function,
    Literal,
    PdlError,
    Problem,
    SearchOptions,
    Status,
    Value,
    generator,
    parse_domain,
    parse_problem,
    solve,
    validate_plan,
)
from rogue.prodigy._expressions import (
    And,
    Call,
    Exists,
    Expression,
    Forall,
    Holds,
    Not,
    Or,
    VariableSpec,
    required,
)
from rogue.prodigy._functions import BUILT_IN
from rogue.prodigy._grounding import World
from rogue.prodigy._relation import Relation
from rogue.prodigy._state import State
from rogue.prodigy._terms import Atom, Term, Variable
from rogue.prodigy._types import Objects

values = st.sampled_from(["a", "b", "c", 1, 2])
rows = st.tuples(values, values, values)
some_rows = st.lists(rows, max_size=30)
patterns = st.tuples(*[values | st.none()] * 3)


@settings(max_examples=80, deadline=None)
@given(some_rows, st.lists(st.tuples(some_rows, some_rows, patterns), max_size=4))
def test_a_relation_finds_what_a_walk_over_all_rows_finds(
    begin: list[tuple[Value, ...]],
    steps: list[tuple[list[tuple[Value, ...]], list[tuple[Value, ...]], tuple[Value | None, ...]]],
) -> None:
    relation, expected = Relation(begin), set(begin)
    for gone, new, pattern in steps:

        def fits(row: tuple[Value, ...], pattern: tuple[Value | None, ...] = pattern) -> bool:
            return all(want is None or want == got for want, got in zip(pattern, row, strict=True))

        assert {row for row in relation.matching(pattern) if fits(row)} == set(
            filter(fits, expected)
        )
        before = relation
        relation = relation.changed(gone, new)
        assert set(before.difference(relation)) == expected ^ ((expected - set(gone)) | set(new))
        expected = (expected - set(gone)) | set(new)
        assert set(relation.rows()) == expected
        assert relation == Relation(expected)


OBJECTS = Objects(TREE, {**CONSTANTS, "felix": "cat"})
ZOO = Domain("zoo", TREE, (), {}, BUILT_IN)
facts = st.one_of(
    st.builds(
        Literal,
        st.sampled_from(["owns", "eats"]),
        st.tuples(*[st.sampled_from(OBJECTS.names())] * 2),
    ),
    st.builds(Literal, st.just("happy"), st.tuples(st.sampled_from([*OBJECTS.names(), 3]))),
)


def brute(state: State, expression: Expression, case: Mapping[str, Value]) -> bool:
    match expression:
        case Holds(atom):
            return state.holds(atom.ground(case))
        case Not(part):
            return not brute(state, part, case)
        case And(parts):
            return all(brute(state, part, case) for part in parts)
        case Or(parts):
            return any(brute(state, part, case) for part in parts)
        case Exists(specs, part):
            return any(brute(state, part, c) for c in cases(state, specs, case))
        case Forall(specs, part):
            return all(brute(state, part, c) for c in cases(state, specs, case))


def cases(
    state: State, specs: tuple[VariableSpec, ...], case: Mapping[str, Value]
) -> list[dict[str, Value]]:
    every = itertools.product(*(OBJECTS.of(spec.types) for spec in specs))
    made = [{**case, **{s.name: v for s, v in zip(specs, each, strict=True)}} for each in every]
    return [c for c in made if all(passes(state, call, c) for s in specs for call in s.calls)]


def passes(state: State, call: Call, case: Mapping[str, Value]) -> bool:
    if call.pattern is not None:
        return state.holds(call.pattern.ground(case))
    one, other = (case[t.name] if isinstance(t, Variable) else t for t in call.terms)
    return one != other


@settings(max_examples=120, deadline=None)
@given(
    st.lists(facts, max_size=12),
    expressions(("<x>", "<y>")),
    *[st.sampled_from(OBJECTS.names())] * 2,
)
def test_expressions_are_true_as_written(
    true: list[Literal], expression: Expression, x: str, y: str
) -> None:
    state, case = State(true), {"<x>": x, "<y>": y}
    world = World(ZOO, OBJECTS, state)
    assert world.holds(expression, case) == brute(state, expression, case)
    ways = list(itertools.islice(world.branches(expression, case), 100))
    if len(ways) < 100:
        is_met = any(all(map(state.holds, way)) for way in ways)
        assert is_met == brute(state, expression, case)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(facts, max_size=12),
    st.lists(st.tuples(*[st.sampled_from(["<a>", "<b>", "rex"])] * 2), min_size=1, max_size=3),
)
def test_given_literals_only_leave_out_what_they_rule_out(
    true: list[Literal], wanted: list[tuple[Term, Term]]
) -> None:
    terms = [tuple(Variable(t) if t[0] == "<" else t for t in pair) for pair in wanted]
    needs = And(tuple(Holds(Atom("owns", pair)) for pair in terms))
    specs = tuple(
        VariableSpec(name, TREE.spec(frozenset(TREE.finite()))) for name in ("<a>", "<b>")
    )
    state = State(true)
    world = World(ZOO, OBJECTS, state)
    found = list(world.combinations(specs, {}, required(needs)))
    assert found == [case for case in cases(state, specs, {}) if brute(state, needs, case)]


COUNTING = """
(infinite-type count #'integerp)
(OPERATOR fill (params <n> <m>)
  (preconds ((<m> count) (<n> (and count {call}))) (litres <n>))
  (effects () ((del (litres <n>)) (add (litres <m>)))))
"""


@generator
def doubled(n: int | None, m: int) -> list[int]:
    assert n is None
    return [m // 2] if m % 2 == 0 else []


@pytest.mark.parametrize(
    ("call", "goal", "steps"),
    [
        ("(increment <n> <m>)", 6, 3),
        ("(add <n> 2 <m>) (>= <n> 3)", 9, 3),
        ("(subtract <m> 5 <n>)", 13, 2),
        ("(multiply <n> 2 <m>)", 12, 2),
        ("(divide <m> 3 <n>)", 27, 2),
        ("(between 0 4 <n>) (< <n> <m>)", 9, 1),
        ("(doubled <n> <m>)", 24, 3),
    ],
)
def test_numbers_are_generated(call: str, goal: int, steps: int) -> None:
    domain = parse_domain(COUNTING.format(call=call), functions={"doubled": doubled})
    text = f"(create-problem (state (litres 3)) (goal (litres {goal})))"
    result = solve(parse_problem(text, domain), SearchOptions(max_nodes=2000))
    assert result.status is Status.SOLVED
    assert len(result.plan) == steps


def test_what_only_goals_can_bind_is_not_called_unsolvable() -> None:
    domain = parse_domain(COUNTING.format(call="(increment <n> <m>)"))
    text = "(create-problem (state (litres 3)) (goal (litres 60)))"
    result = solve(parse_problem(text, domain), SearchOptions(max_nodes=50))
    assert result.status is Status.LIMIT


ROOMS = """
(ptype-of room :top-type)
(OPERATOR close (params <r>)
  (preconds ((<r> room)) (open <r>))
  (effects ((<s> room))
    ((del (open <r>)) (if (next <r> <s>) ((del (draughty <s>)) (add (warm <s>)))))))
(OPERATOR leave (params)
  (preconds () (inside))
  (effects ((<s> room)) ((del (inside)) (del (at <s>)))))
"""


def rooms(state: str, goal: str) -> Problem:
    text = f"(create-problem (objects (a b c room)) (state (and {state})) (goal {goal}))"
    return parse_problem(text, parse_domain(ROOMS))


def test_variables_of_effects_range_over_all_objects_whatever_the_goal() -> None:
    problem = rooms("(inside) (at a) (at b)", "(and (~ (at a)) (~ (at b)))")
    result = solve(problem)
    assert [str(step) for step in result.plan] == ["<LEAVE>"]
    assert result.plan[0].bindings == ()
    problem = rooms("(open a) (next a b) (next a c)", "(and (warm b) (warm c))")
    assert [str(step) for step in solve(problem).plan] == ["<CLOSE A>"]


def test_parameters_of_effects_have_the_value_that_the_goal_gives() -> None:
    punch = """(ptype-of side :top-type) (infinite-type size #'numberp)
    (OPERATOR punch (params <w> <s>)
      (preconds () (cold))
      (effects ((<w> size) (<s> side)) ((add (hole <w> <s>)) (add (rough <s>)))))"""
    text = "(create-problem (objects (left right side)) (state (cold)) (goal (hole 5 left)))"
    problem = parse_problem(text, parse_domain(punch))
    result = solve(problem)
    assert [str(step) for step in result.plan] == ["<PUNCH 5 LEFT>"]
    assert validate_plan(problem, result.plan) is None
    goals = "(and (hole 5 left) (hole 5 right))"
    both = parse_problem(text.replace("(hole 5 left)", goals), problem.domain)
    assert len(solve(both).plan) == 2


def test_a_number_without_generator_comes_from_goal_or_facts() -> None:
    drill = """(ptype-of part :top-type) (infinite-type size #'numberp)
    (OPERATOR drill (params <p> <w> <d>)
      (preconds ((<p> part) (<w> size) (<d> size)) (and (bit <w>) (set-to <d>)))
      (effects () ((add (hole <p> <w>)))))"""
    state = "(and (bit 3) (bit 5) (set-to 7))"
    text = f"(create-problem (objects (p part)) (state {state}) (goal (hole p 5)))"
    result = solve(parse_problem(text, parse_domain(drill)))
    assert [step.args for step in result.plan] == [("p", 5, 7)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            COUNTING.format(call="(> 3 <m>)").replace("(add (litres <m>))", ""),
            "since count is infin",
        ),
        (COUNTING.format(call="(fast <n>)"), "expected a registered function"),
        (COUNTING.format(call="(adds <n> 1 <m>)"), "did you mean add"),
    ],
)
def test_a_number_that_nothing_can_give_is_refused(text: str, message: str) -> None:
    with pytest.raises(PdlError, match=message):
        parse_domain(text)


def test_a_goal_of_objects_of_a_wrong_type_is_refused() -> None:
    domain = parse_domain("(ptype-of box :top-type)" + ROOMS)
    text = "(create-problem (objects (a room) (b box)) (goal (warm b)))"
    with pytest.raises(PdlError, match="object of type room in warm, not of type box"):
        parse_problem(text, domain)
    # What nothing changes may be said of anything.
    text = "(create-problem (objects (a room) (b box)) (state (next b a)) (goal (next b a)))"
    assert solve(parse_problem(text, domain)).status is Status.SOLVED


def test_binding_takes_as_many_steps_as_there_are_facts() -> None:
    asked: list[Value] = []

    def is_near(here: Value, there: Value) -> bool:
        asked.append(there)
        return here != there

    functions: dict[str, Function] = {"is-near": is_near}
    text = """(ptype-of place :top-type)
    (OPERATOR go (params <from> <to>)
      (preconds ((<from> place) (<to> (and place (is-near <from> <to>))))
        (and (at <from>) (road <from> <to>)))
      (effects () ((del (at <from>)) (add (at <to>)))))"""
    places = [f"p{at}" for at in range(2_000)]
    roads = " ".join(f"(road {one} {other})" for one, other in itertools.pairwise(places))
    problem = f"""(create-problem (objects ({" ".join(places)} place))
        (state (and (at p0) {roads})) (goal (at p5)))"""
    result = solve(parse_problem(problem, parse_domain(text, functions=functions)))
    assert len(result.plan) == 5
    assert len(asked) < 100
