"""Control rules: what each meta-predicate answers, and which candidates a rule speaks of."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rogue.prodigy import (
    Candidate,
    Domain,
    FunctionError,
    Instance,
    Literal,
    MetaPredicate,
    NodeKind,
    NodeView,
    Objects,
    Operator,
    PdlError,
    PreferRule,
    Rule,
    SearchOptions,
    State,
    Status,
    Variable,
    parse_domain,
    parse_literal,
    parse_problem,
    solve,
)
from rogue.prodigy._candidates import CandidateIndex
from rogue.prodigy._patterns import BindingsPattern, ListPattern, Pattern, RuleValue, unify
from rogue.prodigy._terms import Term
from rogue.prodigy._types import TypeSpec

YARD = """
(ptype-of thing :top-type)
(ptype-of box thing)
(ptype-of crate box)
(ptype-of place :top-type)
(pinstance-of red blue box)
(pinstance-of big crate)
(pinstance-of yard shed place)
(OPERATOR carry (params <b> <to>)
  (preconds ((<b> box) (<from> place) (<to> place)) (and (at <b> <from>) (open <to>)))
  (effects () ((del (at <b> <from>)) (add (at <b> <to>)))))
(OPERATOR push (params <b> <to>)
  (preconds ((<b> box) (<from> place) (<to> place)) (and (at <b> <from>) (near <from> <to>)))
  (effects () ((del (at <b> <from>)) (add (at <b> <to>)))))
(OPERATOR unlock (params <p>)
  (preconds ((<p> place)) (~ (open <p>)))
  (effects () ((add (open <p>)))))
"""
DOMAIN = parse_domain(YARD)


def lit(text: str) -> Literal:
    return parse_literal(text, DOMAIN)


def operator(name: str) -> Operator:
    found = DOMAIN.operator(name)
    assert found is not None
    return found


def carry(box: str, to: str, *, name: str = "carry", node: int = 0) -> Instance:
    bindings = {"<b>": box, "<from>": "yard", "<to>": to}
    needs = (lit(f"(at {box} yard)"), lit(f"(open {to})"))
    return Instance(operator(name), bindings, needs, lit(f"(at {box} {to})"), node)


STATE = State([lit("(at red yard)"), lit("(at blue yard)"), lit("(open shed)")])
OBJECTS = Objects(DOMAIN.types, DOMAIN.constants)
RED_GOAL, BLUE_GOAL = lit("(at red shed)"), lit("(at blue shed)")


@dataclass(frozen=True)
class View:
    """A search that stands still."""

    state: State = STATE
    objects: Objects = OBJECTS
    goal: Literal | None = RED_GOAL
    operator: Operator | None = None
    pending: tuple[Literal, ...] = (RED_GOAL, BLUE_GOAL)
    needed: dict[Literal, tuple[Instance, ...]] = field(default_factory=dict)
    chosen: tuple[Instance, ...] = ()

    def consumers(self, goal: Literal) -> tuple[Instance, ...]:
        return self.needed.get(goal, ())

    def lacking(self, instance: Instance) -> tuple[Literal, ...]:
        return tuple(p for p in instance.preconditions if not self.state.holds(p))

    def top_level_goals(self, candidate: Literal | Instance) -> tuple[Literal, ...]:
        return ()

    def pending_goals(self) -> tuple[Literal, ...]:
        return self.pending

    def ready(self) -> tuple[Instance, ...]:
        return tuple(c for c in self.chosen if not self.lacking(c))

    def expanded_goals(self) -> tuple[Literal, ...]:
        return tuple(c.goal for c in self.chosen if c.goal)

    def goals(self) -> tuple[Literal, ...]:
        return (lit("(at red shed)"), lit("(~ (open shed))"))

    def objects_of(self, kind: str) -> tuple[str, ...]:
        return self.objects.of(TypeSpec((kind,)))

    def tail(self) -> tuple[Instance, ...]:
        return self.chosen


def with_rule(rule: str, **users: MetaPredicate) -> Domain:
    functions = {name.replace("_", "-"): function for name, function in users.items()}
    return parse_domain(f"{YARD}(CONTROL-RULE it {rule})", meta_predicates=functions)


def spoken_of(
    condition: str,
    then: str,
    candidates: tuple[Candidate, ...],
    view: View | None = None,
    **users: MetaPredicate,
) -> list[str]:
    domain = with_rule(f"(if {condition}) (then {then})", **users)
    assert domain.rules is not None
    (rule,) = domain.rules.rules
    assert isinstance(rule, Rule)
    chosen = rule.speaks_of(view or View(), candidates)
    assert [c for c in candidates if rule.test(view or View(), c, candidates)] == list(chosen)
    return [str(c.number if isinstance(c, NodeView) else c) for c in chosen]


GOALS = tuple(map(lit, ("(at red shed)", "(at blue shed)", "(open yard)", "(~ (open shed))")))
RED, BLUE, OPEN, SHUT = map(str, GOALS)


@pytest.mark.parametrize(
    ("condition", "then", "expected"),
    [
        ("(and)", "select goal (at <b> shed)", [RED, BLUE]),
        ("(candidate-goal (at <b> shed))", "select goal (at <b> <p>)", [RED, BLUE]),
        ("(candidate-goal <g>)", "select goals <g>", [RED, BLUE, OPEN, SHUT]),
        ("(candidate-goal (~ (open <p>)))", "select goal (~ (open <p>))", [SHUT]),
        ("(known (at <b> yard))", "select goal (at <b> shed)", [RED, BLUE]),
        ("(true-in-state (and (at <b> yard) (open <p>)))", "select goal (at <b> <p>)", [RED, BLUE]),
        ("(known (~ (at <b> shed)))", "select goal (at blue shed)", [BLUE]),
        ("(false-in-state (at <b> yard))", "select goal (at <b> shed)", []),
        ("(false-in-state (open yard))", "select goal (open yard)", [OPEN]),
        ("(and (candidate-goal <g>) (known <g>))", "select goal <g>", []),
        ("(and (candidate-goal <g>) (false-in-state <g>))", "select goal <g>",
         [RED, BLUE, OPEN, SHUT]),
        ("(gen-from-pred (open <p>))", "select goal (~ (open <p>))", [SHUT]),
        ("(~ (current-goal (at blue <p>)))", "select goal (open <p>)", [OPEN]),
        ("(or (current-goal (at <b> <p>)) (known (open yard)))", "select goal (at <b> <p>)", [RED]),
        ("(type-of-object <b> crate)", "reject goal (at <b> <p>)", []),
        ("(and (candidate-goal (at <b> <p>)) (type-of-object <b> (or crate box)))",
         "reject goal (at <b> <p>)", [RED, BLUE]),
        ("(p4::type-of-object-gen <p> place)", "reject goal (open <p>)", [OPEN]),
        ("(is-top-level-goal <g>)", "select goal <g>", [RED, SHUT]),
        ("(only-one-candidate-goal)", "select goal (open <p>)", []),
        ("(and (candidate-goal (at <b> <p>)) (diff <b> red))", "select goal (at <b> <p>)", [BLUE]),
        ("(diff <b> red)", "select goal (at <b> <p>)", []),
        ("(and (candidate-goal (at <b> <p>)) (equal <b> red))", "select goal (at <b> <p>)", [RED]),
        ("(equal <b> red)", "select goal (at <b> <p>)", []),
        ("(and (current-goal (at <b> <p>)) (same <c> <b>))", "select goal (at <c> <p>)", [RED]),
        ("(pending-goal (at <b> <p>))", "select goals ((at <b> <p>) (open yard))",
         [RED, BLUE, OPEN]),
    ],
)  # fmt: skip
def test_rules_speak_of_goals(condition: str, then: str, expected: list[str]) -> None:
    assert spoken_of(condition, then, GOALS) == expected


def test_a_conjunction_is_matched_from_left_to_right() -> None:
    # With <b> not bound yet, nothing at all may lie in the yard.
    before = "(and (~ (known (at <b> yard))) (candidate-goal (at <b> <p>)))"
    after = "(and (candidate-goal (at <b> <p>)) (~ (known (at <b> yard))))"
    goals = (*GOALS, lit("(at big shed)"))
    assert spoken_of(before, "select goal (at <b> <p>)", goals) == []
    assert spoken_of(after, "select goal (at <b> <p>)", goals) == ["(at big shed)"]


OPERATORS = tuple(map(operator, ("carry", "push", "unlock")))


@pytest.mark.parametrize(
    ("condition", "then", "expected"),
    [
        ("(and)", "select operator push", ["push"]),
        ("(and)", "select operators (push carry)", ["carry", "push"]),
        ("(and)", "reject operators push unlock", ["push", "unlock"]),
        ("(candidate-operator <o>)", "select operator <o>", ["carry", "push", "unlock"]),
        ("(candidate-operator 'push)", "reject operator carry", ["carry"]),
    ],
)
def test_rules_speak_of_operators(condition: str, then: str, expected: list[str]) -> None:
    assert spoken_of(condition, then, OPERATORS) == expected


INSTANCES = (carry("red", "shed"), carry("blue", "shed"), carry("big", "yard"))


@pytest.mark.parametrize(
    ("condition", "then", "expected"),
    [
        ("(current-ops (push carry))", "select bindings ((<b> . blue))", ["<carry blue shed>"]),
        ("(current-operator push)", "select bindings ((<b> . blue))", []),
        ("(current-goal (at <x> <p>))", "select bindings ((<b> . <x>) (<to> . <p>))",
         ["<carry red shed>"]),
        ("(candidate-bindings ((<b> . <x>) (<to> . yard)))", "reject bindings ((<b> . <x>))",
         ["<carry big yard>"]),
        ("(candidate-bindings (((<b> . <x>) (<to> . yard))))", "reject bindings ((<b> . <x>))",
         ["<carry big yard>"]),
        ("(and)", "select bindings (((<b> . red)) ((<b> . big)))",
         ["<carry red shed>", "<carry big yard>"]),
        ("(candidate-bindings <b>)", "select bindings <b>",
         ["<carry red shed>", "<carry blue shed>", "<carry big yard>"]),
    ],
)  # fmt: skip
def test_rules_speak_of_bindings(condition: str, then: str, expected: list[str]) -> None:
    assert spoken_of(condition, then, INSTANCES, View(operator=operator("carry"))) == expected


CHOSEN = (
    carry("red", "shed", node=7),
    carry("blue", "shed", node=10),
    carry("big", "yard", node=13),
)


@pytest.mark.parametrize(
    ("condition", "then", "expected"),
    [
        ("(candidate-applicable-op <a>)", "reject applied-op <a>", ["red", "blue", "big"]),
        ("(candidate-applicable-op (carry <b> yard))", "select applied-op (carry <b> yard)",
         ["big"]),
        ("(applicable-operator carry)", "select applied-op carry", ["red", "blue", "big"]),
        ("(applicable-operator (carry <b> <p>))", "select applied-op (carry <b> <p>)",
         ["red", "blue"]),
        ("(expanded-operator (carry <b> yard))", "select applied-op (carry <b> <p>)", ["big"]),
        ("(is-op-for-goal (carry <b> <p>) (at blue shed))", "select applied-op (carry <b> <p>)",
         ["blue"]),
        ("(on-goal-stack (at <b> yard))", "select applied-op (carry <b> <p>)", ["big"]),
        ("(goal-introduced-only-by-op (at red shed) (carry <b> <p>))",
         "reject applied-op (carry <b> <p>)", ["blue"]),
        ("(goal-introduced-only-by-op (at blue shed) <o>)", "reject applied-op <o>", []),
    ],
)  # fmt: skip
def test_rules_speak_of_applicable_operators(
    condition: str, then: str, expected: list[str]
) -> None:
    needed = {lit("(at red shed)"): CHOSEN[1:2], lit("(at blue shed)"): CHOSEN[:2]}
    found = spoken_of(condition, then, CHOSEN, View(needed=needed, chosen=CHOSEN))
    assert [text.split()[1] for text in found] == expected


NODES = tuple(NodeView(n, NodeKind.GOAL, "", n, 0, n - 1, None, "", ()) for n in (5, 8, 6))


@pytest.mark.parametrize(
    ("condition", "then", "expected"),
    [
        ("(newest-candidate-node <n>)", "select node <n>", ["8"]),
        ("(oldest-candidate-node <n>)", "select node <n>", ["5"]),
        ("(and (candidate-node <n>) (diff <n> 6))", "reject nodes <n>", ["5", "8"]),
        ("(candidate-node 6)", "select node 6", ["6"]),
    ],
)
def test_rules_speak_of_nodes(condition: str, then: str, expected: list[str]) -> None:
    assert spoken_of(condition, then, NODES) == expected


def preferred(rule: str, current: Candidate, candidates: tuple[Candidate, ...]) -> str:
    rules = with_rule(rule).rules
    assert rules is not None
    (made,) = rules.rules
    assert isinstance(made, PreferRule)
    return str(made.preferred(View(), current, candidates))


def test_rules_prefer_one_candidate_to_another() -> None:
    push = "(if (current-goal (at <b> <p>))) (then prefer operator push <other>)"
    assert preferred(push, OPERATORS[0], OPERATORS) == "push"
    assert preferred(push, OPERATORS[1], OPERATORS) == "None"
    goal = """(if (and (candidate-goal (at <b> <p>)) (candidate-goal (open <q>))))
        (then prefer goal (open <q>) (at <b> <p>))"""
    assert preferred(goal, GOALS[1], GOALS) == OPEN
    assert preferred(goal, GOALS[1], GOALS[:2]) == "None"
    box = "(if (and)) (then prefer bindings ((<b> . blue) (<to> . <x>)) ((<b> . red) (<to> . <x>)))"
    assert preferred(box, INSTANCES[0], INSTANCES) == "<carry blue shed>"
    assert preferred(box, INSTANCES[2], INSTANCES) == "None"


terms: st.SearchStrategy[Term] = st.sampled_from(
    [Variable("<x>"), Variable("<y>"), "red", "blue", "big", "yard", "shed"]
)
rule_patterns: st.SearchStrategy[Pattern] = st.one_of(
    st.sampled_from([Variable("<x>"), Variable("<y>"), "carry", "push"]),
    st.builds(ListPattern, st.sampled_from(["at", "carry"]), st.tuples(terms, terms)),
    st.builds(ListPattern, st.just("open"), st.tuples(terms), st.booleans()),
    st.lists(st.tuples(st.sampled_from(["<b>", "<to>"]), terms), max_size=2).map(
        lambda pairs: BindingsPattern(tuple(pairs))
    ),
)
rule_values: st.SearchStrategy[RuleValue] = st.sampled_from(
    ["red", "big", "shed", *GOALS, *INSTANCES, *OPERATORS]
)


@given(rule_patterns, st.dictionaries(st.sampled_from(["<x>", "<y>"]), rule_values))
def test_an_index_leaves_out_no_candidate_that_matches(
    pattern: Pattern, bindings: dict[str, RuleValue]
) -> None:
    candidates = (*GOALS, *INSTANCES, *OPERATORS)
    found = CandidateIndex(candidates).matching(pattern, bindings)
    kept = {id(c) for c in found}
    assert all(id(c) in kept for c in candidates if unify(pattern, c, bindings) is not None)


def test_users_meta_predicates_are_given_what_is_bound() -> None:
    asked: list[tuple[object, ...]] = []

    def weighs(_view: object, *arguments: object) -> object:
        asked.append(arguments)
        return [{"<kilos>": 20}]

    def is_heavy(_view: object, kilos: object) -> object:
        return kilos == 20

    condition = """(and (candidate-goal (at <b> <p>))
        (weighs <b> <kilos> (at <b> <where>) ((open <p>)) push)  (is-heavy <kilos>))"""
    users = {"weighs": weighs, "is_heavy": is_heavy}
    assert spoken_of(condition, "select goal (at <b> <p>)", GOALS[:1], **users) == [RED]
    kilos, where = Variable("<kilos>"), Variable("<where>")
    at_red = Literal("at", ("red", where))  # type: ignore[arg-type]
    assert asked[0] == ("red", kilos, at_red, (Literal("open", ("shed",)),), "push")


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (lambda _view, _b: 1 // 0, "raised ZeroDivisionError"),
        (lambda _view, _b: ["red"], "gave 'red', expected bindings"),
        (lambda _view, _b: [{"<b>": object()}], "expected bindings"),
    ],
)
def test_a_meta_predicate_that_fails_is_named(answer: MetaPredicate, message: str) -> None:
    with pytest.raises(FunctionError, match=message):
        spoken_of("(weighs <b>)", "select goal (at <b> <p>)", GOALS, weighs=answer)


def test_what_a_meta_predicate_binds_agrees_with_what_is_bound() -> None:
    def knows(_view: object, _b: object) -> object:
        return [{"<b>": "blue"}, {"<b>": "big"}]

    condition = "(and (candidate-goal (at <b> <p>)) (knows <b>))"
    assert spoken_of(condition, "select goal (at <b> <p>)", GOALS, knows=knows) == [BLUE]


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        ("(if (current-ops (push cary))) (then apply)", "did you mean carry?"),
        ("(if (and)) (then select applied-op (carry <b>))", "2 parameters of carry (<b> <to>)"),
        ("(if (and)) (then select bindings ((<box> . red)))", "a variable of an operator"),
        ("(if (and)) (then select bindings ((<b> red)))", "(<v> . value)"),
        ("(if (known (at <b>))) (then apply)", "2 arguments for at, not 1"),
        ("(if (known (opem <b>))) (then apply)", "did you mean open?"),
        ("(if (type-of-object <b> bx)) (then apply)", "did you mean box?"),
        ("(if (and)) (then prefer operator push)", "two candidates, the better one first, not 1"),
        ("(if (and)) (then apply now)", "nothing after apply"),
        ("(if (increment <n> <m>)) (then apply)", "a registered meta-predicate or test"),
        ("(if (candidate-operator (push <x>))) (then apply)", "found <x>, expected an operator"),
        ("(if (current-goal <g>)) (then reject operator <o>)", "or it would reject everything"),
        (
            "(if (and)) (then apply)) (CONTROL-RULE it (if (and)) (then apply)",
            "no control rule has",
        ),
        ("(if (and)) (then select node first)", "number of a node"),
        ("(if ((known (open <p>)))) (then apply)", "expected a meta-predicate"),
        ("(if (current-goal <g>) (current-goal <h>)) (then apply)", "one expression after if"),
    ],
)
def test_an_error_in_a_rule_names_what_is_wrong(rule: str, message: str) -> None:
    with pytest.raises(PdlError) as caught:
        with_rule(rule)
    assert message in str(caught.value)
    assert caught.value.position.line == YARD.count("\n") + 1


DOMAINS = Path(__file__).parent / "domains"


@pytest.mark.parametrize("which", ["oldest", "newest"])
def test_a_rule_of_nodes_makes_the_search_go_broad_or_deep(which: str) -> None:
    rule = f"(CONTROL-RULE it (if ({which}-candidate-node <n>)) (then select node <n>))"
    domain = parse_domain((DOMAINS / "blocks.pdl").read_text() + rule)
    text = """(create-problem (objects (a b c object))
      (state (and (on c a) (on-table a) (on-table b) (clear b) (clear c) (arm-empty)))
      (goal (on a b)))"""
    result = solve(parse_problem(text, domain), SearchOptions(max_nodes=1000, depth_bound=60))
    assert result.status is Status.SOLVED
    assert len(result.plan) == 4
    assert (result.nodes > 40) == (which == "oldest")
