"""The task tree: constraints, ends, kills, lost modules, one event at a time."""

from __future__ import annotations

import pytest
from tree_office import D, F, Office, P, S, only

from tca_bus import NoHandlerError, RefusedError, TaskState
from tca_bus._protocol import Outcome
from tca_bus.tasktree import (
    Cancel,
    Dispatch,
    Ended,
    Freed,
    HandlerMissing,
    KillRequested,
    ProviderLost,
    Record,
    Taken,
    Tree,
    WaitForHandler,
)


def test_siblings_are_handled_while_the_parent_is_and_a_delayed_one_waits():
    office = Office()
    office.goal("A")
    office.goal("B", "A")
    office.goal("C", "A")
    office.goal("D", "A", S | D)
    assert office.last["A"].handling == "handling"
    assert office.handling("B", "C")
    assert office.state("D") is TaskState.INACTIVE
    office.done("B")
    assert office.state("D") is TaskState.INACTIVE
    office.done("C")
    assert office.handling("D")


def test_two_goals_are_planned_at_once_and_their_commands_run_in_order():
    office = Office()
    office.goal("A")
    office.goal("B")
    office.command("a1", "A")
    office.command("b1", "B")
    assert office.handling("A", "B", "a1")
    assert office.state("b1") is TaskState.INACTIVE
    text = office.tree.status("b1").waiting_for
    assert text == "goal B to start being achieved"
    office.done("A")
    office.done("a1")
    assert office.state("A") is TaskState.ACHIEVED
    assert office.handling("b1")


def test_a_goal_is_achieved_after_its_handler_and_all_below_it():
    office = Office()
    office.goal("A")
    office.command("a1", "A")
    office.command("a2", "A")
    office.done("a1", result=3)
    assert office.last["a1"].result == 3
    office.done("A", result={"to": "r-5303"})
    assert office.state("A") is TaskState.PLANNED
    effects = office.done("a2")
    assert office.last["A"].state is TaskState.ACHIEVED
    assert office.last["A"].result == {"to": "r-5303"}
    assert [freed.status.id for freed in only(effects, Freed)] == ["a2", "A"]
    (ended,) = only(effects, Ended)
    assert ended.root == "A"
    assert len(office.tree) == 0


def test_plan_first_holds_commands_until_all_is_expanded():
    office = Office()
    office.goal("A", flags=F)
    office.command("a1", "A")
    office.goal("B", "A")
    office.command("b1", "B")
    office.done("B")
    assert office.state("a1") is TaskState.INACTIVE
    office.done("A")
    assert office.handling("a1")
    assert office.state("b1") is TaskState.INACTIVE
    office.done("a1")
    assert office.handling("b1")


def test_seq_planning_holds_the_expansion_of_the_next():
    office = Office()
    office.goal("A")
    office.goal("B", "A", P)
    office.goal("C", "A", P)
    assert office.handling("B")
    assert office.state("C") is TaskState.INACTIVE
    office.goal("B1", "B")
    office.done("B")
    assert office.state("C") is TaskState.INACTIVE
    office.done("B1")
    assert office.handling("C")


def test_without_constraints_all_runs_at_once():
    office = Office()
    office.goal("A")
    office.command("a1", "A", 0)
    office.command("a2", "A", 0)
    assert office.handling("a1", "a2")


def test_top_level_tasks_of_different_senders_do_not_wait_for_each_other():
    office = Office()
    office.command("A", sender="me")
    office.command("B", sender="me")
    office.command("C", sender="you")
    assert office.handling("A", "C")
    assert office.state("B") is TaskState.INACTIVE
    office.fail("A")
    assert office.handling("B")


def test_contradicting_flags_are_refused_by_name():
    office = Office()
    with pytest.raises(RefusedError, match="PLAN_FIRST and DELAY_PLANNING"):
        office.goal("A", flags=F | D)


def test_points_that_would_wait_for_each_other_are_refused_by_name():
    office = Office()
    office.goal("A", flags=F)
    with pytest.raises(RefusedError, match=r"DELAY_PLANNING.*start of achievement of goal A"):
        office.goal("B", "A", D)
    office.goal("C", "A")


def test_a_submission_repeated_is_one_node():
    office = Office()
    office.goal("A", data={"x": 1})
    assert office.goal("A", data={"x": 1}) == []
    with pytest.raises(RefusedError, match="other values of x"):
        office.goal("A", data={"x": 2})
    with pytest.raises(RefusedError, match="is 'goal', not 'command'"):
        office.command("A")


def test_parents_take_children_only_while_their_handler_may_send_them():
    office = Office()
    with pytest.raises(RefusedError, match="parent A is not in the task tree"):
        office.goal("a1", "A")
    office.command("A")
    office.command("B")
    with pytest.raises(RefusedError, match="parent B is not being handled"):
        office.goal("b1", "B")
    with pytest.raises(RefusedError, match="stands for what is above"):
        office.goal("root")


def test_a_failure_seen_by_the_parents_handler_is_its_affair():
    office = Office()
    office.goal("A")
    office.command("a1", "A")
    office.fail("a1")
    assert office.state("A") is TaskState.PENDING
    office.done("A", seen_failures=("a1",))
    assert office.state("A") is TaskState.ACHIEVED


def test_a_failure_not_seen_fails_the_parent_with_the_whole_chain():
    office = Office()
    office.goal("A")
    office.goal("B", "A")
    office.command("C", "B")
    office.fail("C", "door_blocked")
    office.done("B")
    assert office.state("B") is TaskState.FAILED
    assert office.state("A") is TaskState.PENDING
    office.done("A")
    names = [link.name for link in office.last["A"].failure.chain()]
    assert names == ["child_failed", "child_failed", "door_blocked"]
    assert office.last["A"].failure.cause.node == "B"


def test_a_failure_below_handled_parents_fails_them_at_once_and_stops_the_siblings():
    office = Office()
    office.goal("A")
    office.goal("B", "A")
    office.command("b1", "B", 0)
    office.command("b2", "B", 0)
    office.command("a2", "A")
    office.done("A")
    office.done("B")
    effects = office.fail("b1")
    assert [cancel.id for cancel in only(effects, Cancel)] == ["b2"]
    assert office.state("a2") is TaskState.INACTIVE
    effects = office.done("b2", outcome=Outcome.KILLED)
    assert office.state("b2") is TaskState.KILLED
    assert office.state("a2") is TaskState.KILLED
    assert office.state("A") is TaskState.FAILED
    assert len(only(effects, Ended)) == 1


def test_a_kill_ends_what_waits_at_once_and_asks_what_runs_to_stop():
    office = Office()
    office.goal("A")
    office.command("a1", "A")
    office.command("a2", "A")
    effects = office.apply(KillRequested, "A", "changed my mind")
    assert {cancel.id for cancel in only(effects, Cancel)} == {"A", "a1"}
    assert office.state("a2") is TaskState.KILLED
    assert office.last["A"].existence == "terminating"
    assert office.tree.status("A").waiting_for == "its handler in robot to stop"
    office.done("A", outcome=Outcome.KILLED)
    assert office.tree.status("A").waiting_for == "what is below it to end"
    office.done("a1")
    assert office.state("A") is TaskState.KILLED
    assert office.last["A"].failure.text == "changed my mind"
    assert len(office.tree) == 0


def test_a_kill_below_spares_the_node():
    office = Office()
    office.goal("A")
    office.command("a1", "A")
    office.command("a2", "A")
    office.done("A")
    office.apply(KillRequested, "A", "enough", only_below=True)
    office.done("a1", outcome=Outcome.KILLED)
    assert office.state("a1") is TaskState.KILLED
    assert office.state("A") is TaskState.ACHIEVED


def test_the_root_is_not_killed():
    office = Office()
    with pytest.raises(RefusedError, match="the root"):
        office.apply(KillRequested, "root", "all of it")


def test_a_kill_that_comes_before_the_task_ends_it_at_birth():
    office = Office()
    office.apply(KillRequested, "A", "too late")
    effects = office.goal("A")
    assert office.state("A") is TaskState.KILLED
    assert not only(effects, Dispatch)


def test_a_kill_long_before_the_task_is_forgotten():
    office = Office()
    office.apply(KillRequested, "A", "too late")
    office.time += 100.0
    office.goal("A")
    assert office.handling("A")


def test_children_sent_by_a_handler_that_is_killed_are_killed_at_birth():
    office = Office()
    office.goal("A")
    office.apply(KillRequested, "A", "stop")
    office.command("a1", "A")
    assert office.state("a1") is TaskState.KILLED


def test_a_node_of_a_lost_module_fails():
    office = Office()
    office.goal("A")
    office.command("a1", "A")
    effects = office.apply(ProviderLost, "r1")
    assert office.last["a1"].failure.name == "module_lost"
    assert office.state("A") is TaskState.FAILED
    assert len(only(effects, Record)) == 4


def test_a_node_that_may_be_resent_goes_to_the_next_provider():
    office = Office()
    office.command("A", on_module_lost="resend")
    effects = office.apply(ProviderLost, "r1")
    assert office.state("A") is TaskState.PENDING
    assert not only(effects, WaitForHandler)
    assert office.tree.status("A").waiting_for == "a module that handles 'command'"
    (dispatch,) = only(office.appear("robot", "r2"), Dispatch)
    assert (dispatch.attempt, dispatch.incarnation) == (2, "r2")
    assert office.done("A", attempt=1) == []
    office.done("A")
    assert office.state("A") is TaskState.ACHIEVED


def test_a_node_handled_again_waits_for_the_end_of_what_the_lost_try_began():
    office = Office(capacity=1)
    office.appear("arm", "a1", 1)
    office.goal("A", on_module_lost="resend")
    office.goal("B", "A")
    assert office.last["B"].handler == "arm"
    office.appear("leg", "l1", 1)
    effects = office.apply(ProviderLost, "r1")
    assert [cancel.id for cancel in only(effects, Cancel)] == ["B"]
    assert office.tree.status("A").waiting_for == "what is below it to end"
    effects = office.done("B", outcome=Outcome.KILLED)
    (dispatch,) = only(effects, Dispatch)
    assert (dispatch.id, dispatch.attempt) == ("A", 2)


def test_capacity_holds_back_and_priority_chooses_the_next():
    office = Office(capacity=1)
    office.command("A", flags=0)
    office.command("B", flags=0)
    office.command("C", flags=0, priority=5)
    assert office.state("B") is office.state("C") is TaskState.PENDING
    assert "robot, which has 1" in office.tree.status("B").waiting_for
    office.done("A")
    assert office.handling("C")
    office.done("C")
    assert office.handling("B")


def test_several_providers_share_the_work():
    office = Office(capacity=1)
    office.appear("arm", "a1", 1)
    office.command("A", flags=0)
    office.command("B", flags=0)
    assert {office.last["A"].handler, office.last["B"].handler} == {"robot", "arm"}


def test_without_a_provider_a_task_is_refused_or_waits():
    office = Office()
    facts = {"name": "dance"}
    with pytest.raises(NoHandlerError, match="dance"):
        office.goal("A", **facts)
    effects = office.goal("A", wait_for_handler=5.0, **facts)
    (wait,) = only(effects, WaitForHandler)
    assert wait.seconds == 5.0
    assert office.tree.is_missing("A", wait.number)
    office.apply(HandlerMissing, "A")
    assert office.last["A"].failure.name == "no_handler"


def test_a_task_whose_provider_went_away_before_its_turn_waits_a_while():
    office = Office()
    office.command("A")
    office.command("B")
    effects = office.apply(ProviderLost, "r1")
    assert [wait.id for wait in only(effects, WaitForHandler)] == ["B"]
    office.appear("robot", "r2")
    assert office.handling("B")


def test_taken_makes_it_active():
    office = Office()
    office.command("A")
    assert office.state("A") is TaskState.PENDING
    office.apply(Taken, "A", 1)
    assert office.state("A") is TaskState.ACTIVE
    assert office.apply(Taken, "A", 1) == []


def test_a_handler_cancelled_by_its_own_module_kills_the_node():
    office = Office()
    office.command("A")
    office.done("A", outcome=Outcome.KILLED)
    assert office.state("A") is TaskState.KILLED


def test_sequence_numbers_grow_also_over_a_restart():
    office = Office()
    office.command("A")
    before = office.last["A"].sequence
    tree = Tree(generation=1)
    effects = tree.replay(office.records)
    assert only(effects, Dispatch) == [Dispatch("A", 1, "robot", "r1")]
    assert tree.status("A").sequence > before + 1000


@pytest.mark.slow
def test_a_very_deep_tree_is_killed_without_recursion():
    office = Office(capacity=10_000)
    office.goal("n0")
    for depth in range(1, 2000):
        office.goal(f"n{depth}", f"n{depth - 1}")
    effects = office.apply(KillRequested, "n0", "too deep")
    assert len(only(effects, Cancel)) == 2000


def test_a_task_goes_on_after_a_restart_when_the_one_before_it_had_ended():
    office = Office()
    office.command("A")
    office.goal("B")
    office.command("b1", "B")
    office.done("B")
    office.done("A")
    alive = [event for event in office.records if event.id != "A"]
    tree = Tree(generation=1)
    effects = tree.replay(alive)
    assert only(effects, Dispatch) == [Dispatch("b1", 1, "robot", "r1")]
    assert tree.status("B").achievement == "achieving"
