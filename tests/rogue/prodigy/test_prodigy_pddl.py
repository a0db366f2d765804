"""PDDL: what it means in PRODIGY's terms, and what is refused."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from prodigy_random_cases import Case, as_problem, cases

from rogue.prodigy import (
    Mode,
    PdlError,
    SearchOptions,
    Solutions,
    Status,
    Task,
    solutions,
    solve,
    validate_plan,
)
from rogue.prodigy.pddl import read_domain, read_problem

DOMAIN = """
; Lights in rooms, and a robot that carries lamps. Upper and lower case are one.
(define (domain Lights)
  (:requirements :adl :derived-predicates :action-costs)
  (:types lamp robot - thing room)
  (:constants hall - room)
  (:predicates (at ?t - thing ?r - room) (holding ?l - lamp) (on ?l - lamp)
               (next ?a ?b - room) (lit ?r - room) (BRIGHT))
  (:functions (total-cost) - number (way ?a ?b - room) - number)

  (:derived (lit ?r - room) (exists (?l - lamp) (and (at ?l ?r) (on ?l))))
  (:derived (bright) (forall (?r - room) (lit ?r)))

  (:action go
    :parameters (?who - robot ?a ?b - room)
    :precondition (and (at ?who ?a) (or (next ?a ?b) (next ?b ?a)) (not (= ?a ?b)))
    :effect (and (not (at ?who ?a)) (at ?who ?b)
                 (forall (?l - lamp) (when (holding ?l) (and (at ?l ?b) (not (at ?l ?a)))))
                 (increase (total-cost) (* 2 (way ?a ?b)))))
  (:action take
    :parameters (?who - robot ?l - lamp ?r - room)
    :precondition (and (at ?who ?r) (at ?l ?r) (not (exists (?l - lamp) (holding ?l))))
    :effect (and (holding ?l) (increase (total-cost) 1)))
  (:action drop
    :parameters (?l - lamp)
    :precondition (holding ?l)
    :effect (not (holding ?l)))
  (:action switch
    :parameters (?l - lamp)
    :precondition (imply (holding ?l) (on ?l))
    :effect (on ?l)))
"""

PROBLEM = """
(define (problem two-lamps)
  (:domain lights)
  (:objects r2 - robot a b - lamp cellar - room)
  (:init (at r2 hall) (at a hall) (at b hall) (next cellar hall)
         (= (total-cost) 0) (= (way hall cellar) 2.5) (= (way cellar hall) 3))
  (:goal {goal})
  (:metric minimize (total-cost)))
"""


def task(goal: str, domain: str = DOMAIN, problem: str = PROBLEM) -> Task:
    return read_problem(problem.replace("{goal}", goal), read_domain(domain))


@pytest.mark.parametrize(
    ("goal", "plan", "cost"),
    [
        ("(on a)", ["switch a"], 0),
        ("(lit cellar)", ["switch a", "take r2 a hall", "go r2 hall cellar"], 6),
        ("(at r2 cellar)", ["go r2 hall cellar"], 5),
        ("(and (at a hall) (not (on a)))", [], 0),
        ("(and)", [], 0),
    ],
)
def test_a_goal_is_reached_at_its_cost(goal: str, plan: list[str], cost: float) -> None:
    read = task(goal)
    result = solve(read.problem)
    steps = [" ".join(map(str, (s.operator, *s.args))) for s in result.plan]
    assert sorted(steps) == sorted(plan)
    assert read.costs.total(result.plan) == cost
    assert validate_plan(read.problem, result.plan) is None


@pytest.mark.parametrize("mode", list(Mode))
def test_derived_predicates_quantifiers_and_conditional_effects_mean_what_pddl_says(
    mode: Mode,
) -> None:
    read = task("(bright)")
    result = solve(read.problem, SearchOptions(mode=mode))
    assert result.status is Status.SOLVED
    assert validate_plan(read.problem, result.plan) is None
    assert [s.operator for s in result.plan].count("go") == 1


def test_a_variable_of_either_type_takes_both() -> None:
    domain = """(define (domain d) (:requirements :typing) (:types cup pot lid - thing)
        (:constants kettle - pot)
        (:predicates (full ?v - (either cup pot)) (shut ?t - thing))
        (:action fill :parameters (?v - (either cup pot)) :effect (full ?v))
        (:action shut-all :parameters ()
          :precondition (forall (?v - (either cup pot)) (full ?v))
          :effect (and (shut kettle) (forall (?t - thing) (shut ?t)))))"""
    problem = """(define (problem p) (:domain d) (:objects mug - cup top - lid)
        (:init (not (full mug)) (full kettle)) (:goal (shut top)))"""
    read = task("", domain=domain, problem=problem).problem
    assert [str(step) for step in solve(read).plan] == ["<FILL MUG>", "<SHUT-ALL>"]
    with pytest.raises(PdlError, match=r"top, which is a lid, expected a \(or cup pot\)"):
        task("", domain=domain, problem=problem.replace("(full kettle)", "(full top)"))


ROADS = """
(define (domain roads)
  (:requirements :adl :derived-predicates)
  (:types place)
  (:predicates (road ?a ?b - place) (blocked ?a ?b - place) (open ?a ?b - place)
               (linked ?a ?b - place) (cut-off ?a - place))
  (:derived (open ?a ?b - place) (and (road ?a ?b) (not (blocked ?a ?b))))
  (:derived (linked ?a ?b - place)
    (or (open ?a ?b) (exists (?c - place) (and (open ?a ?c) (linked ?c ?b)))))
  (:derived (cut-off ?a - place) (not (exists (?b - place) (linked ?b ?a))))
  (:action clear-road
    :parameters (?a ?b - place)
    :precondition (blocked ?a ?b)
    :effect (not (blocked ?a ?b)))
  (:action block
    :parameters (?a ?b - place)
    :precondition (and (road ?a ?b) (not (cut-off ?a)))
    :effect (blocked ?a ?b)))
"""
PLACES = """
(define (problem links)
  (:domain roads)
  (:objects a b c d - place)
  (:init (road a b) (road b c) (road c d) (blocked b c) (blocked c d))
  (:goal {goal}))
"""


@pytest.mark.parametrize("mode", list(Mode))
@pytest.mark.parametrize(
    ("goal", "steps"),
    [
        ("(linked a b)", 0),
        ("(linked a d)", 2),
        ("(and (linked b c) (cut-off d))", 1),
        ("(not (linked a d))", 0),
        ("(linked d a)", None),
    ],
)
def test_a_derived_predicate_that_uses_itself_becomes_a_rule(
    goal: str, steps: int | None, mode: Mode
) -> None:
    problem = task(goal, domain=ROADS, problem=PLACES).problem
    assert [rule.name for rule in problem.domain.inference_rules] == ["derive-linked"]
    result = solve(problem, SearchOptions(mode=mode))
    assert result.status is (Status.UNSOLVABLE if steps is None else Status.SOLVED)
    assert len(result.plan) == (steps or 0)
    assert steps is None or validate_plan(problem, result.plan) is None


def test_an_inner_variable_hides_the_outer_one() -> None:
    take = task("(holding b)").problem.domain.operator("take")
    assert take is not None
    assert "exists" not in take.params
    assert "<l:2>" in str(take.precondition)


def test_an_inequality_that_must_hold_tests_its_later_variable() -> None:
    go = task("(and)").problem.domain.operator("go")
    assert go is not None
    assert [len(v.calls) for v in go.variables] == [0, 0, 1]


def test_other_equalities_are_facts() -> None:
    read = task("(exists (?x ?y - lamp) (and (on ?x) (at ?y hall) (or (= ?x ?y) (on ?y))))")
    result = solve(read.problem)
    assert len(result.plan) == 1
    assert validate_plan(read.problem, result.plan) is None


def test_an_action_whose_cost_is_not_known_is_none() -> None:
    no_way_back = PROBLEM.replace("(= (way cellar hall) 3)", "")
    goal = "(and (at r2 hall) (lit cellar))"
    assert solve(task(goal).problem).status is Status.SOLVED
    assert solve(task(goal, problem=no_way_back).problem).status is Status.UNSOLVABLE


def test_without_costs_a_plan_costs_its_steps() -> None:
    domain = "(define (domain d) (:predicates (p) (q)) (:action a :parameters () :effect (p)))"
    read = read_problem("(define (problem x) (:domain d) (:init) (:goal (p)))", read_domain(domain))
    assert read.costs.total(solve(read.problem).plan) == 1
    assert not read.minimize


WAYS = """
(define (domain ways)
  (:requirements :typing :action-costs)
  (:types place)
  (:predicates (at ?p - place) (rail ?a ?b - place) (path ?a ?b - place))
  (:functions (total-cost) - number (fare ?a ?b - place) - number)
  (:action ride
    :parameters (?to ?from - place)
    :precondition (and (rail ?from ?to) (at ?from))
    :effect (and (not (at ?from)) (at ?to) (increase (total-cost) (fare ?from ?to))))
  (:action walk
    :parameters (?to ?from - place)
    :precondition (and (path ?from ?to) (at ?from))
    :effect (and (not (at ?from)) (at ?to) (increase (total-cost) 2))))
"""
JOURNEY = """
(define (problem journey)
  (:domain ways)
  (:objects home bridge park town - place)
  (:init (at home) (rail home town) (= (fare home town) 9) (path home bridge) (path bridge park)
         (path park town) (rail bridge town) (= (fare bridge town) 5))
  (:goal (at town))
  (:metric minimize (total-cost)))
"""


@pytest.mark.parametrize("mode", list(Mode))
def test_ever_cheaper_plans_are_found_though_they_are_longer(mode: Mode) -> None:
    read = read_problem(JOURNEY, read_domain(WAYS))
    options = SearchOptions(mode=mode, solutions=Solutions.CHEAPER, step_cost=read.costs.of)
    plans = [solution.plan for solution in solutions(read.problem, options)]
    costs = [read.costs.total(plan) for plan in plans]
    assert read.minimize
    assert costs[0] == 9
    assert costs[-1] == 6
    assert costs == sorted(set(costs), reverse=True)
    assert [step.operator for step in plans[-1]] == ["walk"] * 3


def test_cheaper_without_costs_is_shorter() -> None:
    options = SearchOptions(solutions=Solutions.CHEAPER)
    read = read_problem(JOURNEY, read_domain(WAYS)).problem
    assert [len(solution.plan) for solution in solutions(read, options)] == [1]


@settings(max_examples=40, deadline=None)
@given(cases, st.sampled_from(Mode))
def test_the_same_problem_in_both_languages_is_searched_the_same(case: Case, mode: Mode) -> None:
    options = SearchOptions(mode=mode, max_nodes=300, proof_states=300)
    first = solve(as_problem(case), options)
    second = solve(as_pddl(case).problem, options)
    assert (first.status, first.nodes, first.plan) == (second.status, second.nodes, second.plan)
    assert first.trace == second.trace


def as_pddl(case: Case) -> Task:
    known = " ".join(f"({name} ?x)" for name in "pqr")
    actions = [f"(:action never :parameters (?x - thing) :precondition (and (never) {known}))"]
    for at, step in enumerate(case.steps):
        needs = " ".join(pddl_literal(p) for p in step.needs)
        changes = " ".join(pddl_literal(p) for p in step.adds)
        changes += " ".join(pddl_literal((*p[:2], False)) for p in step.deletes)
        actions.append(
            f"(:action step{at} :parameters (?x ?y - thing)"
            f" :precondition (and {needs}) :effect (and {changes}))"
        )
    domain = f"""(define (domain d) (:requirements :typing) (:types thing)
        (:predicates (never) (p ?x - thing) (q ?x - thing) (r ?x - thing)) {" ".join(actions)})"""
    state = " ".join(f"({name} {thing})" for name, thing in sorted(case.start))
    goal = " ".join(pddl_literal(p) for p in case.goal)
    problem = f"""(define (problem problem) (:domain d) (:objects a b - thing)
        (:init {state}) (:goal (and {goal})))"""
    return read_problem(problem, read_domain(domain))


def pddl_literal(pattern: tuple[str, str, bool]) -> str:
    term = pattern[1].replace("<", "?").replace(">", "")
    text = f"({pattern[0]} {term})"
    return text if pattern[2] else f"(not {text})"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (":adl", ":adl :durative-actions", "domain:4:23: found :durative-actions, expected"),
        (":adl", ":fluents", "expected a supported requirement"),
        (":adl", ":non-deterministic", "expected a supported requirement"),
        ("room)\n", "room - lamp room - thing)\n", "one supertype, which is"),
        ("robot - thing room", "robot - thing thing - lamp", "not its own supertype"),
        ("hall - room", "hall - roon", "did you mean room"),
        ("(on ?l - lamp)", "(on ?l - lamp) (on ?l - lamp)", "not declared twice"),
        ("(at ?l ?r) (on ?l)", "(at ?l) (on ?l)", "found at with 1 arguments, expected 2"),
        ("(at ?l ?r) (on ?l)", "(at ?r ?r) (on ?l)", "r, which is a room, expected a thing"),
        ("(at ?l ?r) (on ?l)", "(not (lit ?r)) (on ?l)", "does not use its own negation"),
        ("(at ?who ?r)", "(at ?whom ?r)", "found ?whom, expected a variable that is declared; did"),
        ("(holding ?l)\n    :effect", "(holdin ?l)\n    :effect", "did you mean holding?"),
        ("(holding ?l)\n    :effect", "(on hal)\n    :effect", "did you mean hall?"),
        ("(not (holding ?l))", "(lit hall)", "expected a predicate that actions may change"),
        ("(total-cost) 1", "(total-cost) (- 1)", "a cost is never negative"),
        ("(increase (total-cost) 1)", "(assign (total-cost) 1)", "functions may only be costs"),
        ("(increase (total-cost) 1)", "(increase (way hall hall) 1)", "may only be costs"),
        ("(holding ?l) (on ?l)", "(> (way hall hall) 1) (on ?l)", "a condition without numbers"),
        (
            "(:action drop",
            "(:action take",
            "a name that no action and no rule has",
        ),
        (":parameters (?l - lamp)\n", ":parameters (?l ?l - lamp)\n", "not declared twice"),
        (
            "(:action drop",
            "(:durative-action drop",
            "expected :action or :derived; did you mean :action?",
        ),
        ("(:action drop\n    :parameters (?l - lamp)", "(:action drop", "expected :parameters"),
    ],
)
def test_what_is_wrong_in_a_domain_is_named_with_its_place(
    old: str, new: str, message: str
) -> None:
    assert old in DOMAIN
    with pytest.raises(PdlError) as caught:
        read_domain(DOMAIN.replace(old, new, 1))
    assert message in str(caught.value)
    assert caught.value.position.line > 1


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (":domain lights", ":domain light", "found light, expected lights"),
        ("(at a hall)", "(at a hal)", "problem:5:29: found hal, expected an object or a constant"),
        ("(at a hall)", "(at hall a)", "hall, which is a room, expected a thing"),
        ("(at a hall)", "(lit hall)", "expected a predicate that is not derived"),
        ("(at a hall)", "(= (way hall cellar) 7)", "one value of (way hall cellar)"),
        ("(at a hall)", "(at 5 (at a hall))", "found 5, expected ')' or a name"),
        ("a b - lamp", "a b - lamp a - room", "an object that is not also a lamp"),
        ("{goal}", "(on ?x)", "found ?x, expected a variable that is declared"),
        ("minimize (total-cost)", "maximize (total-cost)", "(:metric minimize (total-cost))"),
        ("minimize (total-cost)", "minimize (way hall hall)", "(:metric minimize (total-cost))"),
        ("(define", "(defin", "found defin, expected define"),
        ("(total-cost)))", "(total-cost))", "found the end of the text, expected ')'"),
    ],
)
def test_what_is_wrong_in_a_problem_is_named_with_its_place(
    old: str, new: str, message: str
) -> None:
    assert old in PROBLEM
    with pytest.raises(PdlError) as caught:
        task("(on a)", problem=PROBLEM.replace(old, new, 1))
    assert message in str(caught.value)


def test_a_domain_is_no_problem_and_a_problem_no_domain() -> None:
    with pytest.raises(PdlError, match="found domain, expected problem"):
        read_problem(DOMAIN, read_domain(DOMAIN))
    with pytest.raises(PdlError, match="found problem, expected domain"):
        read_domain(PROBLEM)


def test_definitions_that_multiply_are_bounded() -> None:
    uses = "".join(f"(:derived (d{n}) (and (d{n - 1}) (or (d{n - 1}) (p))))" for n in range(1, 40))
    names = "".join(f"(d{n})" for n in range(40))
    text = f"""(define (domain d) (:predicates (p) {names}) (:derived (d0) (p)) {uses}
        (:action a :parameters () :precondition (d39) :effect (p)))"""
    with pytest.raises(PdlError, match="at most 1000 uses of derived predicates"):
        read_domain(text)


def test_deep_nesting_is_refused_at_its_place() -> None:
    text = "(define (domain d) (:predicates (p))\n(:action a :parameters () :precondition\n"
    with pytest.raises(PdlError, match=r"domain:3:491: found '\(', expected at most 100 levels"):
        read_domain(text + "(not " * 5000 + "(p)" + ")" * 5000)


@settings(max_examples=60, deadline=None)
@given(st.text(alphabet="()?-:= ab\n;=", max_size=60))
def test_any_text_is_read_or_refused_with_a_place(text: str) -> None:
    with pytest.raises(PdlError) as caught:
        read_domain(text)
    assert caught.value.position.line >= 1


def test_many_objects_are_read() -> None:
    lamps = " ".join(f"l{n}" for n in range(2000))
    facts = " ".join(f"(at l{n} hall)" for n in range(2000))
    text = PROBLEM.replace("a b - lamp", f"a b {lamps} - lamp").replace("(at a hall)", facts)
    read = task("(on l7)", problem=text)
    assert len(read.problem.objects.names()) == 2005
