"""Domains, problems and control rules as text; errors with their place."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from rogue.prodigy import (
    Function,
    FunctionError,
    Literal,
    PdlError,
    SearchOptions,
    SearchResult,
    SearchView,
    Status,
    generator,
    load_domain,
    parse_domain,
    parse_literal,
    parse_problem,
    solve,
)

DOMAINS = Path(__file__).parent / "domains"
BLOCKS = (DOMAINS / "blocks.pdl").read_text()
TYPES = "(ptype-of room :top-type)\n"
GO = """(OPERATOR go (params <r>)
  (preconds ((<r> room)) (free <r>))
  (effects () ((add (at <r>)))))
"""


def problem(goal: str = "(at a)", state: str = "(free a)", more: str = "") -> str:
    return f"(create-problem (objects (a b room){more})\n  (state (and {state}))\n  (goal {goal}))"


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        ("(ptype-of room :top-type", "1:25", "expected ')' for '(' at domain:1:1"),
        (TYPES + ")", "2:1", "found ')'"),
        ("(ptype-of room building)", "1:16", "expected a type that is declared with ptype-of"),
        (
            "(ptype-of a b)\n(ptype-of b a)",
            "1:13",
            "expected a supertype that is not its own subtype",
        ),
        ("(OPERATER go)", "1:2", "did you mean operator?"),
        (TYPES + GO.replace("<r> room", "<r> rom"), "3:19", "did you mean room?"),
        (TYPES + GO.replace("(free <r>)", "(free <q>)"), "3:32", "a variable that is declared"),
        (
            TYPES + GO + GO.replace("go", "walk").replace("(at <r>)", "(at <r> <r>)"),
            "7:21",
            "1 arg",
        ),
        (TYPES + GO.replace("(add", "(ad"), "4:17", "expected add, del, if or forall"),
        (
            TYPES + GO.replace("room))", "(and room (near <r>))))"),
            "3:30",
            "a registered function",
        ),
        (TYPES + GO.replace("(params <r>)", "(params <q>)"), "2:22", "a variable declared in"),
        (TYPES + "(OPERATOR go (preconds () (p)))", "2:1", "expected (effects ...)"),
        (TYPES + GO + GO, "5:11", "a name that no operator and no inference rule"),
        ('(ptype-of "room', "1:11", "ending the string"),
        ("#| never ends", "1:1", "'|#' ending the comment"),
        ("(" * 200, "1:101", "at most 100 levels"),
        ("(infinite-type n #'nubmerp)", "1:20", "did you mean numberp?"),
        ("; nothing\n", "1:1", "expected a domain with its operators"),
    ],
)
def test_an_error_in_a_domain_names_its_place(text: str, place: str, message: str) -> None:
    with pytest.raises(PdlError) as caught:
        parse_domain(text)
    assert str(caught.value).startswith(f"domain:{place}: ")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "place", "message"),
    [
        (problem("(at c)"), "3:13", "an object of the problem"),
        (problem("(att a)"), "3:10", "did you mean at?"),
        (problem("(at a b)"), "3:9", "1 arguments for at, not 2"),
        (problem("(at <x>)"), "3:13", "a variable that is declared"),
        (problem(state="(~ (free a))"), "2:15", "a fact that is true"),
        (problem(more=" (c rooom)"), "1:40", "did you mean room?"),
        ("(create-problem (gaol (at a)))", "1:18", "did you mean goal?"),
        ("(create-problem (objects (a room)))", "1:1", "(goal ...) in the problem"),
        ("", "1:1", "one problem"),
    ],
)
def test_an_error_in_a_problem_names_its_place(text: str, place: str, message: str) -> None:
    domain = parse_domain(TYPES + GO)
    with pytest.raises(PdlError) as caught:
        parse_problem(text, domain)
    assert str(caught.value).startswith(f"problem:{place}: ")
    assert message in str(caught.value)
    assert caught.value.position.line >= 1


def test_a_file_that_is_not_text_is_refused_with_its_place(tmp_path: Path) -> None:
    path = tmp_path / "noise.pdl"
    path.write_bytes(b"(ptype-of a b)\n\xff\xfe")
    with pytest.raises(PdlError, match=r"noise\.pdl:2:1: found byte 0xff"):
        load_domain(path)


def test_literals_are_read_with_their_sign() -> None:
    domain = parse_domain(TYPES + GO)
    assert parse_literal("(AT a)", domain) == Literal("at", ("a",))
    assert parse_literal("(~ (at a))", domain) == Literal("at", ("a",), False)
    with pytest.raises(PdlError):
        parse_literal("(at a) (at b)", domain)


NUMBERS = """
(infinite-type count #'integerp)
(OPERATOR INC
  (params <n> <m>)
  (preconds ((<n> (and count (gen-from-pred (counter <n>))))
             (<m> (and count (next <n> <m>))))
    (counter <n>))
  (effects () ((del (counter <n>)) (add (counter <m>)))))
"""


@generator
def successor(n: int, m: int | None) -> list[int]:
    return [n + 1]


def numbers(function: Function) -> SearchResult:
    domain = parse_domain(NUMBERS, functions={"next": function})
    text = "(create-problem (state (counter 0)) (goal (counter 1)))"
    return solve(parse_problem(text, domain), SearchOptions(max_nodes=200))


def test_infinite_types_are_generated_by_functions() -> None:
    result = numbers(successor)
    assert result.status is Status.SOLVED
    assert [step.args for step in result.plan] == [(0, 1)]


def endless(_n: int, _m: int | None) -> Iterator[int]:
    yield from itertools.count()


def breaking(_n: int, _m: int | None) -> Iterator[int]:
    yield 1
    raise OSError("out of order")


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda n, m: [1 // 0], r"function \(next 0 None\) raised ZeroDivisionError"),
        (breaking, r"function \(next 0 None\) raised OSError\('out of order'\)"),
        (endless, r"gave more than 10000 values"),
        (lambda n, m: 5, r"gave 5, expected values"),
        (lambda n, m: [None], r"gave None, expected a value"),
        (lambda n: [], r"raised TypeError"),
    ],
)
def test_a_function_that_fails_is_named(function: Function, message: str) -> None:
    with pytest.raises(FunctionError, match=message):
        numbers(generator(function))


RULES = """
(CONTROL-RULE PARCEL-FIRST
  (if (and (candidate-goal (at parcel <x>)) (~ (true-in-state (at parcel <x>)))))
  (then select goal (at parcel <x>)))
(CONTROL-RULE NO-SILLY-ROCKET
  (if (and (current-operator load) (candidate-bindings ((<r> . <vehicle>))) (is-silly <vehicle>)))
  (then reject bindings ((<r> . <vehicle>))))
(CONTROL-RULE FLY-RATHER
  (if (current-goal (rocket-at <r> <p>)))
  (then prefer operator fly <other>))
"""


def test_control_rules_of_a_text_decide() -> None:
    asked: list[object] = []

    def is_silly(_view: SearchView, vehicle: object) -> bool:
        asked.append(vehicle)
        return False

    domain = parse_domain(
        (DOMAINS / "rockets.pdl").read_text() + RULES, meta_predicates={"is-silly": is_silly}
    )
    text = (DOMAINS / "rockets-two.pdl").read_text()
    result = solve(parse_problem(text, domain), SearchOptions(level=3))
    assert result.status is Status.SOLVED
    assert set(asked) == {"apollo"}
    fired = "    Firing select goals rule parcel-first to get ((at parcel there))"
    assert result.trace.index(fired) < result.trace.index("  5   n5 (at parcel there)")


def test_a_rule_that_rejects_everything_leaves_no_choice() -> None:
    rules = RULES + "(CONTROL-RULE NO-LOAD (if (current-goal <g>)) (then reject operator load))"
    domain = parse_domain(
        (DOMAINS / "rockets.pdl").read_text() + rules,
        meta_predicates={"is-silly": lambda _view, _vehicle: False},
    )
    result = solve(parse_problem((DOMAINS / "rockets-two.pdl").read_text(), domain))
    assert result.status is Status.LIMIT
    assert "there is a plan" in result.reason
    why = "...no choices for operators: all rejected by control rule no-load"
    assert any(why in line for line in result.trace)


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        (
            "(if (candidate-gaol (on a b))) (then select goal (on a b))",
            "did you mean candidate-goal",
        ),
        ("(if (candidate-goal (on a b))) (then elect goal (on a b))", "did you mean select"),
        ("(if (candidate-goal (on a b))) (then select gaol (on a b))", "did you mean goal"),
        ("(if (current-goal <g>)) (then select operator stak)", "did you mean stack"),
        ("(if (current-goal)) (then select operator stack)", "1 arguments for current-goal"),
        ("(if (current-goal <g>))", "a name, (if ...) and (then ...)"),
    ],
)
def test_an_error_in_a_control_rule_names_its_place(rule: str, message: str) -> None:
    with pytest.raises(PdlError) as caught:
        parse_domain(f"{BLOCKS}(CONTROL-RULE wrong {rule})", file="rules.pdl")
    assert caught.value.position.line == BLOCKS.count("\n") + 1
    assert message in str(caught.value)


FURNITURE = """
;;; A file as it lies on somebody's disk.
(in-package "USER")
#| #| once |# (OPERATOR left-out) |#
(setf *depth* '(a b)) (defun near (x y) (char= x #\\( y))
(create-problem-space 'rooms :current t)
(ptype-of ROOM :Top-Type)
(ptype-of Hall Room)
(pinstance-of lobby foyer HALL)
(Operator GO
  (preconds nil (and))
  (effects nil ((add (at lobby)))))
(operator WAIT
  (params)
  (preconds ((<r> (and Room (not Hall)))) (at lobby))
  (effects () (add (waited <r>)))
  (primary-effects (waited <r>)))
"""


def test_what_stands_around_a_domain_is_read_past() -> None:
    domain = parse_domain(FURNITURE)
    assert domain.name == "rooms"
    assert domain.constants == {"lobby": "hall", "foyer": "hall"}
    text = """(in-package "USER")
        (setf (current-problem) (create-problem (name 'p) (objects (object-is r1 room) (a b hall))
          (state (and)) (igoal (waited r1))))"""
    result = solve(parse_problem(text, domain))
    assert [str(step) for step in result.plan] == ["<GO>", "<WAIT>"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("(event rain (preconds () ()))", "expected no exogenous events"),
        ('(load "rules.lisp")', "the text of that file"),
        ("(setf x (operator go))", "found setf"),
        ("(create-problem-space a) (create-problem-space b)", "only one create-problem-space"),
    ],
)
def test_what_needs_lisp_is_refused(text: str, message: str) -> None:
    with pytest.raises(PdlError, match=re.escape(message)):
        parse_domain(text)


@pytest.mark.parametrize(
    ("spec", "names"),
    [
        ("(or cat dog)", "cat dog rex"),
        ("(not cat)", "dog rex rock stone"),
        ("(and animal (not cat))", "rex dog"),
        ("(and (or animal stone) (not (or cat stone)))", "rex dog"),
        ("(or (and animal (not dog)) puppy)", "cat rex"),
        ("(and (not cat) (not stone) animal)", "dog rex"),
        ("top-type", "cat dog rex rock stone"),
    ],
)
def test_types_combine(spec: str, names: str) -> None:
    text = f"""(ptype-of animal :top-type) (ptype-of cat animal) (ptype-of dog animal)
        (ptype-of puppy dog) (ptype-of stone :top-type)
        (pinstance-of cat cat) (pinstance-of dog dog) (pinstance-of rex puppy)
        (pinstance-of rock stone stone)
        (operator see (preconds ((<x> {spec}))) (effects () (add (seen <x>))))"""
    domain = parse_domain(text)
    (spec_of_x,) = (v.types for v in domain.operators[0].variables)
    objects = parse_problem("(create-problem (goal ()))", domain).objects
    assert set(objects.of(spec_of_x)) == set(names.split())
    assert all(objects.is_a(name, spec_of_x) for name in names.split())


@pytest.mark.parametrize(
    ("types", "spec", "message"),
    [
        ("(ptype-of b :top-type)", "(and a b)", "that some object can have"),
        ("(ptype-of b a)", "(and b (not a))", "that some object can have"),
        ("(ptype-of b a)", "(xor a b)", "a type, (or TYPE ...)"),
        ("(ptype-of b a)", "(and (diff <x> <x>))", "a type after and"),
        ("(ptype-of a b) (ptype-of b :top-type)", "a", "a type that is not also declared with"),
        ("(ptype-of top-type a)", "a", "a type other than the topmost one"),
    ],
)
def test_types_that_cannot_be_are_refused(types: str, spec: str, message: str) -> None:
    text = f"""(ptype-of a :top-type) {types}
        (operator see (preconds ((<x> {spec}))) (effects () (add (seen <x>))))"""
    with pytest.raises(PdlError, match=re.escape(message)):
        parse_domain(text)


def test_a_type_of_which_the_test_raises_is_named_with_the_word() -> None:
    text = "(infinite-type size #'is-small) (operator o (preconds () (p 1)) (effects () ()))"
    domain = parse_domain(text, functions={"is-small": lambda value: value < 3})
    with pytest.raises(PdlError, match="found ten, expected an object of the problem, or a size"):
        parse_literal(
            "(p ten)", domain, parse_problem("(create-problem (goal ()))", domain).objects
        )


def test_symbols_can_be_an_infinite_type() -> None:
    text = """(infinite-type name #'symbolp)
      (operator call (params <n>) (preconds ((<n> name)) ()) (effects () ((add (called <n>)))))"""
    problem = parse_problem("(create-problem (goal (called rover)))", parse_domain(text))
    assert [step.args for step in solve(problem).plan] == [("rover",)]
