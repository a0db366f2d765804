"""Inference rules at work in a search."""

from __future__ import annotations

import pytest
from prodigy_office_runs import shown

from rogue.prodigy import (
    Execute,
    InferenceError,
    Literal,
    Mode,
    Poll,
    Problem,
    Search,
    SearchOptions,
    Status,
    parse_domain,
    parse_problem,
    solve,
    validate_plan,
)

HOUSE = """
(ptype-of room :top-type)
(OPERATOR go (params <from> <to>)
  (preconds ((<from> room) (<to> room)) (and (at <from>) (linked <from> <to>) (open <to>)))
  (effects () ((del (at <from>)) (add (at <to>)))))
(OPERATOR unlock (params <room>)
  (preconds ((<room> room)) (has-key))
  (effects () ((add (open <room>)))))
(OPERATOR wait (params) (preconds () (and)) (effects () ((add (waited)))))
(OPERATOR fetch (params) (preconds () (at hall)) (effects () ((add (has-key)))))
(INFERENCE-RULE symmetric (mode eager) (params)
  (preconds ((<a> room) (<b> room)) (linked <a> <b>)) (effects () ((add (linked <b> <a>)))))
(INFERENCE-RULE sees (mode eager) (params <a> <b>)
  (preconds ((<a> room) (<b> room)) (and (at <a>) (linked <a> <b>) (open <b>)))
  (effects () ((add (sees <b>)))))
(INFERENCE-RULE proud (mode eager) (params)
  (preconds () (sees attic)) (effects () ((add (proud)))))
(INFERENCE-RULE reach-next (params <a> <b>)
  (preconds ((<a> room) (<b> room)) (and (linked <a> <b>) (open <b>) (reach <a>)))
  (effects () ((add (reach <b>)))))
(INFERENCE-RULE reach-self (params <b>)
  (preconds ((<b> room)) (at <b>)) (effects () ((add (reach <b>)))))
"""
ROOMS = "(objects (hall stairs attic room))"
LINKS = "(linked hall stairs) (linked stairs attic)"


def house(goal: str, facts: str = "(at hall) (open hall) (open stairs)") -> Problem:
    text = f"(create-problem {ROOMS} (state (and {LINKS} {facts})) (goal {goal}))"
    return parse_problem(text, parse_domain(HOUSE))


def fact(text: str) -> Literal:
    name, *args = text.split()
    return Literal(name, tuple(args))


def test_static_rules_fire_at_the_root_for_good() -> None:
    search = Search(house("(at hall)"))
    assert search.state.holds(fact("linked attic stairs"))


@pytest.mark.parametrize("mode", list(Mode))
def test_a_lazy_goal_is_chained_on_and_fired_in_its_node(mode: Mode) -> None:
    problem = house("(reach attic)", "(at hall) (open hall)")
    search = Search(problem, SearchOptions(mode=mode))
    list(search.events())
    assert search.result is not None
    assert search.result.status is Status.SOLVED
    assert validate_plan(problem, search.result.plan) is None
    assert {step.operator for step in search.result.plan} == {"fetch", "unlock"}
    lines = "\n".join(search.trace)
    assert "<reach-next stairs attic>" in lines
    assert "<REACH-NEXT" not in lines


def test_rules_that_can_fire_at_once_need_no_step() -> None:
    problem = house("(reach stairs)")
    result = solve(problem)
    assert (result.status, result.plan) == (Status.SOLVED, ())
    assert result.trace == (
        "  2 n2 (done)",
        "  4 n4 <*finish*>",
        "  5   n5 (reach stairs)",
        "  7   n7 <reach-next hall stairs> [1]",
        "  8     n8 (reach hall)",
        " 10     n10 <reach-next stairs hall> ...goal loop with node 5",
        " 10     n12 <reach-self hall>",
        "Achieved top-level goals.",
    )


def test_eager_rules_do_not_chain_until_the_next_application() -> None:
    problem = house("(at stairs)", "(at hall) (open hall) (open stairs) (open attic)")
    search = Search(problem, SearchOptions(execute=True))
    seen: list[tuple[bool, bool]] = []
    for event in search.events():
        if isinstance(event, Execute):
            if not seen:
                search.add_goal((), fact("waited"))
            search.executed()
            sees, proud = fact("sees attic"), fact("proud")
            seen.append((search.state.holds(sees), search.state.holds(proud)))
    assert shown(search.executed_operators()) == ["go hall stairs", "wait"]
    assert seen == [(True, False), (True, True)]


def test_what_loses_its_support_is_retracted_under_an_executed_outcome() -> None:
    problem = house("(at attic)", "(at hall) (open hall) (open stairs) (open attic)")
    search = Search(problem, SearchOptions(execute=True))
    assert search.state.holds(fact("sees stairs"))
    failed = False
    for event in search.events():
        if isinstance(event, Execute):
            if not failed:
                failed = True
                search.executed(added=[], deleted=[fact("at hall")])
                assert not search.state.holds(fact("sees stairs"))
                search.assert_facts(fact("at stairs"))
            else:
                search.executed()
        elif isinstance(event, Poll) and failed and not search.executed_operators()[1:]:
            assert search.state.holds(fact("sees attic"))
    assert search.result is not None
    assert search.result.status is Status.SOLVED
    assert shown(search.executed_operators())[1:] == ["go stairs attic"]


def test_a_change_from_outside_retracts_what_a_lazy_rule_said() -> None:
    problem = house("(and (reach stairs) (open attic))", "(at hall) (open hall) (open stairs)")
    search = Search(problem, SearchOptions(execute=True))
    closed = False
    for event in search.events():
        if isinstance(event, Poll) and not closed and search.state.holds(fact("reach stairs")):
            closed = True
            search.retract_facts(fact("open stairs"))
            assert not search.state.holds(fact("reach stairs"))
        elif isinstance(event, Execute):
            search.executed()
    assert closed
    assert search.result is not None
    assert search.result.status is Status.SOLVED
    assert search.state.holds(fact("reach stairs"))


def test_the_absence_of_what_follows_lazily_is_not_taken_for_granted() -> None:
    problem = house("(~ (reach stairs))")
    assert solve(problem).status is Status.UNSOLVABLE
    absent = Literal("reach", ("stairs",), positive=False)
    search = Search(house("(has-key)"), SearchOptions(execute=True))
    for event in search.events():
        if isinstance(event, Poll) and absent not in search.goals:
            search.add_goal((), absent)
        elif isinstance(event, Execute):
            search.executed()
    assert search.result is not None
    assert search.result.status is Status.UNSOLVABLE


def test_a_new_object_may_take_the_support_of_a_rule_for_all() -> None:
    text = """(ptype-of lamp :top-type)
    (INFERENCE-RULE dark (mode eager) (params)
      (preconds () (forall ((<l> lamp)) (off <l>))) (effects () ((add (dark)))))
    (OPERATOR switch (params <l>) (preconds ((<l> lamp)) (on <l>))
      (effects () ((del (on <l>)) (add (off <l>)))))"""
    domain = parse_domain(text)
    lamp = Literal("on", ("second",))
    problem = Problem.build(domain, objects={"lamp": ["first"]}, facts=[fact("on first")])
    search = Search(problem, SearchOptions(execute=True))
    search.add_goal((), fact("dark"))
    for event in search.events():
        if isinstance(event, Execute):
            if "second" not in search.objects:
                search.add_object("second", "lamp")
                search.assert_facts(lamp)
            search.executed()
    assert shown(search.executed_operators()) == ["switch first", "switch second"]


def test_a_rule_that_hangs_on_its_own_absence_is_refused() -> None:
    text = "(INFERENCE-RULE liar (params) (preconds () (~ (lie))) (effects () ((add (lie)))))"
    problem = Problem.build(parse_domain(text), objects={}, goals=[fact("lie")])
    with pytest.raises(InferenceError, match="liar"):
        solve(problem)
