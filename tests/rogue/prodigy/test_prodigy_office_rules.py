"""The working rules keep planning linear; rules can be added to them."""

from __future__ import annotations

import pytest
from prodigy_office_runs import (
    ITEMS,
    PEOPLE,
    ROOMS,
    metres,
    plain,
    random_batch,
    run,
    shown,
)

from rogue.errands import Errand
from rogue.prodigy import (
    Action,
    Candidate,
    Choice,
    Decided,
    Instance,
    Literal,
    PreferRule,
    Rule,
    RuleSet,
    Search,
    SearchView,
    Status,
    validate_plan,
)


@pytest.mark.parametrize("count", range(1, 9))
@pytest.mark.parametrize("rooms", [12, 24, 48])
def test_a_batch_takes_four_and_sixteen_nodes_an_errand(count: int, rooms: int) -> None:
    for seed in range(2):
        batch = random_batch(count, rooms, seed)
        search = run(batch.search(plain(batch.metres)))
        assert search.result is not None
        assert search.result.status is Status.SOLVED
        assert len(search.nodes()) <= min(4 + 16 * count, 150)
        done = shown(search.executed_operators())
        assert sum(step.startswith("deliver-item") for step in done) == count
        assert not any("..." in line for line in search.trace)
        assert validate_plan(search.problem, search.result.plan) is None


def test_two_errands_of_one_person_keep_their_rooms() -> None:
    errands = [
        Errand("mitchell", "delivermail", "r-5303", "r-5313"),
        Errand("mitchell", "deliverfax", "r-5307", "r-5305"),
    ]
    switches = plain(metres)
    problem = switches.problem(errands, rooms=ROOMS, people=PEOPLE, items=ITEMS, at="r-5301")
    search = run(Search(problem, switches.options, switches.rules))
    done = shown(search.executed_operators())
    for errand in errands:
        assert f"acquire-item {errand.pickup} {errand.user} {errand.item}" in done
        assert f"deliver-item {errand.deliver} {errand.user} {errand.item}" in done


def test_a_rule_added_by_a_program_decides_what_is_applied() -> None:
    def is_of_the_late(view: SearchView, it: Candidate, among: tuple[Candidate, ...]) -> bool:
        urgent = Literal("has-item", ("user1", "item1"))
        serves = {id(c): urgent in view.top_level_goals(c) for c in among if _is_instance(c)}
        return any(serves.values()) and not serves[id(it)]

    batch = random_batch(3, 12, 5)
    urgent = Rule("urgent-first", Choice.APPLIED_OP, Action.REJECT, is_of_the_late)
    search = run(batch.search(plain(batch.metres), RuleSet((urgent,))))
    done = shown(search.executed_operators())
    delivered = [step.split()[2] for step in done if step.startswith("deliver-item")]
    assert delivered[0] == "user1"
    rules = {f.rule for d in search.decisions for f in d.rules}
    assert "urgent-first" in rules


def _is_instance(candidate: Candidate) -> bool:
    return isinstance(candidate, Instance)


def test_decisions_name_their_alternatives_and_the_rule_that_decided() -> None:
    batch = random_batch(2, 12, 1)
    search = run(batch.search(plain(batch.metres)))
    applied = [d for d in search.decisions if d.choice is Choice.APPLIED_OP]
    assert all(d.chosen in d.alternatives for d in applied)
    assert "order-of-tour" in {d.reason for d in applied}
    assert all(isinstance(d, Decided) and d.reason for d in search.decisions)


def test_a_cycle_of_preferences_is_reported_and_ends() -> None:
    always = PreferRule("dog-chases-tail", Choice.GOAL, lambda _view, _a, _b: True)
    batch = random_batch(2, 12, 1)
    search = run(batch.search(plain(batch.metres), RuleSet((always,))))
    actions = {f.action for d in search.decisions for f in d.rules if f.rule == "dog-chases-tail"}
    assert actions == {"prefer", "prefer cycle"}
    assert search.result is not None
    assert search.result.status is Status.SOLVED
