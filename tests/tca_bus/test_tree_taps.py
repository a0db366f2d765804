"""Wiretaps (tca.md 3.10): all eighteen conditions, on tasks and on messages."""

from __future__ import annotations

from functools import partial

import pytest
from tree_office import Office
from tree_robot import Approve, Fetch, Hear, Low, Robot, Step

from tca_bus import (
    ConfigError,
    KilledError,
    Module,
    RefusedError,
    TapCondition,
    TaskFailedError,
    TaskState,
    tap,
)
from tca_bus._attachments import BLOCKING, FOLLOWERS, GATES, Sending, Tap
from tca_bus._monitor_spec import MonitorSpec
from tca_bus._orders import Point
from tca_bus.tasktree import (
    Deregistered,
    Detached,
    HandlerMissing,
    KillRequested,
    ProviderLost,
    Submitted,
    Tell,
)
from tca_bus.testing import eventually

LISTENER = Sending(name="tap", task_class="command")
HEARD = Sending(name="heard", task_class="inform")
POINT_OF = {condition: point for point, found in FOLLOWERS.items() for condition in found}
POINT_OF[TapCondition.AFTER_HANDLED] = Point.END_HANDLING
NEEDS_FAILURE = {TapCondition.WHEN_FAILURE, TapCondition.AFTER_FAILURE}
ON_SUCCESS = sorted(set(POINT_OF) - NEEDS_FAILURE)


def tapped(condition: TapCondition, *, by: Sending = LISTENER, **facts) -> Tap:
    return Tap(id="t", condition=condition, listener=by, **facts)


def reach(office: Office, condition: TapCondition) -> None:
    """Let G come to the point that the condition holds."""
    if condition is TapCondition.WHEN_FAILURE:
        office.fail("G")
    elif condition.startswith("When"):
        office.done("G")


def test_there_are_eighteen_conditions_of_which_eight_hold_something():
    assert len(TapCondition) == 18
    assert len(GATES) == 7
    assert BLOCKING - set(GATES) == {TapCondition.WHEN_KILLED}
    follows = set(POINT_OF) | {TapCondition.WHEN_SENT, TapCondition.AFTER_REPLIED}
    assert set(TapCondition) == follows | BLOCKING


@pytest.mark.parametrize("condition", sorted(GATES))
def test_a_blocking_tap_holds_its_point_until_its_listener_is_done(condition):
    office = Office()
    office.goal("G", attachments=[tapped(condition)])
    node = office.tree.node("G")
    reach(office, condition)
    (listener,) = office.sent("tap")
    assert office.tree.status(listener).parent == "G"
    assert GATES[condition] not in node.passed
    if condition is not TapCondition.BEFORE_ACHIEVING:
        assert office.last["G"].waiting_for == f"tap {listener} to be achieved"
    office.done(listener)
    assert GATES[condition] in node.passed
    assert not office.sent("tap")


@pytest.mark.parametrize("condition", sorted(GATES))
@pytest.mark.parametrize("how", ["failed", "killed", "lost", "missing"])
def test_a_listener_that_does_not_do_its_part_holds_nothing_for_ever(condition, how):
    office = Office()
    office.appear("ears", "e1") if how == "lost" else None
    facts = {"name": "nobody"} if how == "missing" else {}
    listener = LISTENER.model_copy(update=facts)
    office.goal("G", attachments=[tapped(condition, by=listener)])
    node = office.tree.node("G")
    reach(office, condition)
    (gate,) = office.sent(listener.name)
    match how:
        case "failed":
            office.fail(gate)
        case "killed":
            office.apply(KillRequested, gate, "not now")
            office.stop(gate)
        case "lost":
            office.apply(ProviderLost, office.tree.node(gate).incarnation)
        case "missing":
            office.apply(HandlerMissing, gate)
    assert GATES[condition] in node.passed or (how == "lost" and not node.is_alive)


@pytest.mark.parametrize("condition", sorted(GATES))
def test_an_interlock_fails_what_it_holds(condition):
    office = Office()
    office.goal("G", attachments=[tapped(condition, on_failure="fail")])
    reach(office, condition)
    (listener,) = office.sent("tap")
    office.fail(listener, "not_safe")
    if office.state("G") is not TaskState.FAILED:
        office.stop("G")
    names = [link.name for link in office.last["G"].failure.chain()]
    assert office.state("G") is TaskState.FAILED
    assert names in (["tap_failed", "not_safe"], ["broken"])
    assert (names == ["broken"]) == (condition is TapCondition.WHEN_FAILURE)


@pytest.mark.parametrize("condition", ON_SUCCESS)
def test_what_follows_a_point_is_sent_when_it_has_passed_and_holds_nothing(condition):
    office = Office()
    office.goal("G", attachments=[tapped(condition)])
    node = office.tree.node("G")
    if not office.sent("tap"):
        assert POINT_OF[condition] not in node.passed
        office.done("G")
    (listener,) = office.sent("tap")
    assert POINT_OF[condition] in node.passed
    assert office.tree.status(listener).parent is None
    if office.state("G") is not TaskState.ACHIEVED:
        office.done("G")
    assert office.state("G") is TaskState.ACHIEVED
    assert office.handling(listener)


@pytest.mark.parametrize("condition", [TapCondition.AFTER_FAILURE, TapCondition.AFTER_HANDLED])
def test_what_follows_a_failure(condition):
    office = Office()
    office.goal("G", attachments=[tapped(condition), tapped_success()])
    office.fail("G")
    assert office.state("G") is TaskState.FAILED
    assert len(office.sent("tap")) == 1


def tapped_success() -> Tap:
    return Tap(id="s", condition=TapCondition.AFTER_SUCCESS, listener=LISTENER)


def test_when_sent_is_before_all_else_and_holds_nothing():
    office = Office(capacity=0)
    office.goal("G", attachments=[tapped(TapCondition.WHEN_SENT)])
    assert office.state("G") is TaskState.PENDING
    assert len(office.sent("tap")) == 1


def test_when_killed_is_a_clean_up_and_not_for_what_fails():
    office = Office()
    office.command("G", flags=0, attachments=[tapped(TapCondition.WHEN_KILLED)])
    office.command("H", flags=0, attachments=[tapped(TapCondition.WHEN_KILLED)])
    office.fail("H")
    assert office.state("H") is TaskState.FAILED
    office.apply(KillRequested, "G", "enough")
    assert not office.sent("tap")
    office.stop("G")
    (listener,) = office.sent("tap")
    assert office.last["G"].existence == "terminating"
    office.done(listener)
    assert office.state("G") is TaskState.KILLED


STARTS = {
    "WhenSent",
    "BeforeHandling",
    "WhileHandling",
    "BeforeAchieving",
    "WhileAchieving",
}
ENDS = {
    "succeeds": {
        "AfterHandled",
        "WhenSuccess",
        "AfterSuccess",
        "WhenAchieved",
        "AfterAchieved",
    },
    "fails": {"AfterHandled", "WhenFailure", "AfterFailure"},
    "killed": {"WhenKilled"},
}
PLANNING = {
    "succeeds": {"BeforePlanning", "WhilePlanning", "WhenPlanned", "AfterPlanned"},
    "fails": {"BeforePlanning", "WhilePlanning"},
    "killed": {"BeforePlanning", "WhilePlanning"},
}


def all_taps(listener: Sending) -> list[Tap]:
    conditions = sorted(set(TapCondition) - {TapCondition.AFTER_REPLIED})
    return [
        Tap(id=condition, condition=condition, listener=listener, payload="notice")
        for condition in conditions
    ]


@pytest.mark.parametrize("fate", sorted(ENDS))
@pytest.mark.parametrize("kind", ["goal", "command", "monitor"])
def test_in_the_life_of_a_task_each_condition_comes_once_that_it_has(kind, fate):
    office = Office()
    monitor = MonitorSpec(kind="point", action=Sending(name="command", task_class="command"))
    facts = {"name": "watch", "monitor": monitor} if kind == "monitor" else {}
    office.submit("G", kind, None, 0, attachments=all_taps(LISTENER), **facts)
    while "G" in office.tree and (office.sent("tap") or office.handling("G")):
        for listener in office.sent("tap"):
            office.done(listener)
        if "G" in office.tree and office.handling("G") and not office.sent("tap"):
            end(office, fate)
    assert "G" not in office.tree
    expected = STARTS | ENDS[fate] | (PLANNING[fate] if kind == "goal" else set())
    assert sorted(told_of(office)) == sorted(expected)


def end(office: Office, fate: str) -> None:
    if fate == "fails":
        office.fail("G")
    elif fate == "succeeds":
        office.done("G")
    elif office.last["G"].existence == "alive":
        office.apply(KillRequested, "G", "enough")
    else:
        office.stop("G")


def told_of(office: Office) -> list[str]:
    sent = [event for event in office.records if isinstance(event, Submitted)]
    return [event.task.data["condition"] for event in sent if event.task.name == "tap"]


def test_a_listener_may_be_an_inform_where_nothing_is_held():
    office = Office()
    effects = office.command("G", attachments=[tapped(TapCondition.WHEN_SENT, by=HEARD)])
    (told,) = [effect for effect in effects if isinstance(effect, Tell)]
    assert told.sending.name == "heard"
    with pytest.raises(RefusedError, match="waits for its listener"):
        office.register("goal", tapped(TapCondition.WHEN_ACHIEVED, by=HEARD))


def test_a_tap_on_a_message_holds_for_tasks_that_are_there_and_for_those_to_come():
    office = Office(capacity=1)
    office.command("A", flags=0)
    office.command("B", flags=0)
    office.register("command", tapped(TapCondition.BEFORE_HANDLING))
    office.command("C", flags=0)
    office.done("A")
    assert not office.handling("B")
    by_parent = {office.tree.status(id).parent: id for id in office.sent("tap")}
    assert sorted(by_parent) == ["B", "C"]
    office.done(by_parent["B"])
    assert office.handling("B")
    assert not office.handling("C")


def test_a_tap_for_which_something_waits_lets_it_go_when_it_is_taken_away():
    office = Office()
    office.register("command", tapped(TapCondition.BEFORE_HANDLING))
    office.command("A", flags=0)
    office.apply(Deregistered, "t")
    for listener in office.sent("tap"):
        office.stop(listener)
    assert office.handling("A")
    office.goal("B", flags=0, attachments=[tapped(TapCondition.WHEN_SUCCESS)])
    office.done("B")
    office.apply(Detached, "B", "t")
    for listener in office.sent("tap"):
        office.stop(listener)
    assert office.state("B") is TaskState.ACHIEVED


def test_taps_end_with_the_module_that_attached_them():
    office = Office()
    office.appear("guard", "g1")
    office.register("command", tapped(TapCondition.BEFORE_HANDLING, incarnation="g1"))
    office.apply(ProviderLost, "g1")
    office.command("A")
    assert office.handling("A")


def test_listeners_are_not_tapped_themselves():
    office = Office()
    office.register("tap", tapped(TapCondition.BEFORE_HANDLING))
    office.command("A", attachments=[Tap(id="u", condition="WhileHandling", listener=LISTENER)])
    (listener,) = office.sent("tap")
    assert office.handling(listener)


def test_a_task_that_is_handled_again_is_held_again():
    office = Office()
    office.command("A", on_module_lost="resend", attachments=[tapped("BeforeHandling")])
    office.done(office.sent("tap")[0])
    office.appear("other", "o1")
    office.apply(ProviderLost, "r1")
    (listener,) = office.sent("tap")
    assert not office.handling("A")
    office.done(listener)
    assert office.last["A"].attempt == 2


@pytest.mark.bus
async def test_a_blocking_tap_holds_the_task_until_the_listener_is_done(user: Module, robot: Robot):
    async with await user.attach(tap("BeforeHandling", Approve), to=Step):
        await (await user.execute(Step(name="a"))).result(timeout=10.0)
    await (await user.execute(Step(name="b"))).result(timeout=10.0)
    assert robot.done == ["approve a", "a", "b"]
    assert robot.notices[0].message == "step"


@pytest.mark.bus
async def test_an_interlock_that_refuses_fails_what_it_holds(user: Module, robot: Robot):
    robot.refuse = True
    async with await user.attach(tap("BeforeHandling", Approve, on_failure="fail"), to=Step):
        task = await user.execute(Step(name="a"))
        with pytest.raises(TaskFailedError) as failed:
            await task.result(timeout=10.0)
    assert [link.name for link in failed.value.failure.chain()] == ["tap_failed", "refused"]
    assert robot.done == []


@pytest.mark.bus
async def test_a_tap_gives_its_listener_the_data_of_what_is_tapped(user: Module, robot: Robot):
    async with await user.attach(tap("AfterSuccess", Hear), to=Step):
        await (await user.execute(Step(name="a"))).result(timeout=10.0)
        await eventually(lambda: "hear a" in robot.done)


@pytest.mark.bus
async def test_taps_that_make_no_sense_are_refused(user: Module):
    with pytest.raises(ConfigError, match="BeforeHandling"):
        tap("BeforeHandlin", Hear)
    with pytest.raises(ConfigError, match="a goal, a command, an inform"):
        tap("WhenSent", Low)


@pytest.mark.bus
async def test_over_the_bus_each_condition_is_told(user: Module, robot: Robot):
    conditions = sorted(set(TapCondition) - {TapCondition.AFTER_REPLIED})
    taps = [tap(condition, Approve) for condition in conditions]
    done = await user.expand(Fetch(what=""), attach=taps)
    await done.result(timeout=20.0)
    failing = await user.execute(Step(name="a", fails=True), attach=taps)
    with pytest.raises(TaskFailedError):
        await failing.result(timeout=20.0)
    waiting = await user.execute(Step(name="wait"), attach=taps)
    await eventually(lambda: "wait" in robot.done)
    await waiting.kill("enough")
    with pytest.raises(KilledError):
        await waiting.result(timeout=20.0)
    expected = {
        done.id: STARTS | ENDS["succeeds"] | PLANNING["succeeds"],
        failing.id: STARTS | ENDS["fails"],
        waiting.id: STARTS | ENDS["killed"],
    }
    for id, wanted in expected.items():
        await eventually(partial(is_told_of, robot, id, len(wanted)))
        told = [notice.condition for notice in robot.notices if notice.task == id]
        assert sorted(told) == sorted(wanted)


def is_told_of(robot: Robot, task: str, times: int) -> bool:
    return sum(notice.task == task for notice in robot.notices) >= times
