"""Temporal constraints (tca.md 3.6): points, relations, delays, times, and what is refused."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tree_office import D, F, Office, P, S
from tree_robot import Robot, Step

from tca_bus import BusOptions, Module, RefusedError, TaskRef, TaskState
from tca_bus._orders import NAMEABLE, Moment, Order, Point, PointRef
from tca_bus.tasktree import KillRequested

A, B, C = TaskRef("A"), TaskRef("B"), TaskRef("C")
POINTS = sorted(NAMEABLE)


def moment(ref: TaskRef, point: Point) -> Moment:
    return Moment(PointRef(task=ref.id, point=point))


def finish(office: Office) -> None:
    """Let every handler that has something succeed, until nothing is left."""
    while office.tree.statuses():
        handling = [s.id for s in office.tree.statuses() if s.handling == "handling"]
        if handling:
            office.done(handling[0])
        else:
            assert office.alarms, [(s.id, s.waiting_for) for s in office.tree.statuses()]
            office.wake()


IDS = st.sampled_from("ABCD")


@st.composite
def orders(draw: st.DrawFn) -> Order:
    first = PointRef(task=draw(IDS), point=draw(st.sampled_from(POINTS)))
    then = PointRef(task=draw(IDS.filter(lambda id: id != first.task)), point=first.point)
    then = then.model_copy(update={"point": draw(st.sampled_from(POINTS))})
    relation = draw(st.sampled_from(["<", "<=", "="]))
    delay = draw(st.sampled_from([0.0, 3.0])) if relation != "=" else 0.0
    return Order(first=first, relation=relation, then=then, delay=delay)


@settings(max_examples=300, deadline=None)
@given(
    before=st.lists(orders(), max_size=6),
    sent=st.permutations("ABCD"),
    kinds=st.lists(st.sampled_from(["goal", "command"]), min_size=4, max_size=4),
    flags=st.lists(st.integers(0, 15).filter(lambda flag: flag & 12 != 12), min_size=4, max_size=4),
    along=st.lists(st.lists(orders(), max_size=2), min_size=4, max_size=4),
)
def test_what_is_admitted_can_be_carried_out(before, sent, kinds, flags, along):
    office, kind_of = Office(), dict(zip("ABCD", kinds, strict=True))
    office.goal("boss")
    nodes = {}
    for id, kind in kind_of.items():
        office.prepare(id, kind, "boss")
        nodes[id] = office.tree.node(id)
    kept = [order for order in before if try_to(office.constrain, order)]
    for id, flag, more in zip(sent, flags, along, strict=True):
        own = [order for order in more if id in {order.first.task, order.then.task}]
        if try_to(office.submit, id, kind_of[id], "boss", flag, orders=own):
            kept += own
        elif not try_to(office.submit, id, kind_of[id], "boss", 0):
            office.apply(KillRequested, id, "its place cannot be filled")
    stated = office.time
    finish(office)
    for order in kept:
        first = nodes[order.first.task].passed.get(order.first.point)
        then = nodes[order.then.task].passed.get(order.then.point)
        if first is not None and then is not None and then > stated:
            assert first + order.delay <= then, str(order)


def try_to(act, *arguments, **facts) -> bool:
    try:
        act(*arguments, **facts)
    except RefusedError:
        return False
    return True


@pytest.mark.parametrize(("first", "then"), list(product(POINTS, POINTS)))
def test_any_point_of_a_goal_may_come_before_any_of_another(first, then):
    office = Office()
    office.prepare("A", "goal")
    office.prepare("B", "goal")
    office.constrain(moment(A, first) <= moment(B, then))
    a, b = office.tree.node("A"), office.tree.node("B")
    office.goal("B", flags=0)
    office.goal("A", flags=0)
    finish(office)
    assert a.passed[first] <= b.passed[then]
    assert list(a.passed) != []


@pytest.mark.parametrize("point", POINTS)
def test_the_reverse_of_a_constraint_is_refused_and_the_points_named(point):
    office = Office()
    office.goal("boss")
    office.prepare("A", "goal", "boss")
    office.prepare("B", "goal", "boss")
    office.constrain(moment(A, point) <= moment(B, point))
    with pytest.raises(RefusedError) as refused:
        office.constrain(moment(B, point) <= moment(A, point))
    assert f"{point} of A" in str(refused.value)
    assert f"{point} of B" in str(refused.value)


@pytest.mark.parametrize("interval", ["handling", "planning", "achieving"])
def test_an_interval_does_not_end_before_it_starts(interval):
    office = Office()
    office.prepare("A", "goal")
    points = getattr(A, interval)
    with pytest.raises(RefusedError, match="points come in order"):
        office.constrain(points.end <= points.start)


def test_two_goals_of_which_each_is_to_be_planned_before_the_other_are_refused():
    office = Office()
    office.prepare("A", "goal")
    office.prepare("B", "goal")
    office.constrain(A.planning.end <= B.planning.start)
    with pytest.raises(RefusedError, match="end of planning of B"):
        office.constrain(B.planning.end <= A.planning.start)


def test_a_cycle_over_three_tasks_is_refused_whole():
    office = Office()
    for id in "ABC":
        office.prepare(id)
    with pytest.raises(RefusedError, match=r"of C.*of A|of A.*of C"):
        office.constrain(
            A.achieving.end <= B.achieving.start,
            B.achieving.end <= C.achieving.start,
            C.achieving.end <= A.achieving.start,
        )
    for id in "CBA":
        office.command(id, flags=0)
    assert office.handling("A", "B", "C")


def test_a_task_sent_into_its_place_may_not_close_a_cycle():
    office = Office()
    office.goal("boss")
    office.prepare("A", parent="boss")
    office.prepare("B", parent="boss")
    office.constrain(A.achieving.end <= B.achieving.start)
    office.command("B", "boss", S)
    with pytest.raises(RefusedError, match=r"task A.*end of achievement of B"):
        office.command("A", "boss", S)
    office.command("A", "boss", 0)
    assert office.handling("A")


def test_constraints_that_come_with_a_task_are_held_against_the_tree():
    office = Office()
    office.command("A")
    with pytest.raises(RefusedError, match=r"start of achievement of A has passed"):
        office.command("B", orders=[B.achieving.end <= A.achieving.start])
    with pytest.raises(RefusedError, match="one top-level task only"):
        office.command("B", orders=[B.achieving.end.together_with(A.achieving.end)])
    with pytest.raises(RefusedError, match="depends on when a handler is free"):
        office.goal("B", orders=[B.handling.end.together_with(B.achieving.end)])
    with pytest.raises(RefusedError, match=r"end of achievement of B.*start of achievement of B"):
        office.command("B", orders=[B.achieving.end <= A.achieving.end])
    with pytest.raises(RefusedError, match="task C is not in the tree"):
        office.command("B", orders=[B.achieving.end <= C.achieving.end])


def test_a_place_may_be_filled_by_a_goal_that_is_planned_late():
    office = Office()
    office.command("A")
    office.prepare("B", "goal")
    office.goal("B", flags=S | D)
    assert office.state("B") is TaskState.INACTIVE
    office.done("A")
    assert office.handling("B")
    office.done("B")
    assert office.state("B") is TaskState.ACHIEVED


def test_planning_that_was_held_back_before_it_was_delayed_holds_achievement_too():
    office = Office()
    office.command("A", sender="you")
    office.prepare("B", "goal")
    office.constrain(A.achieving.end <= B.planning.start)
    office.goal("B", flags=D)
    assert office.passed("B") == set()
    office.done("A")
    assert {Point.START_PLANNING, Point.START_ACHIEVING} <= office.passed("B")


def test_points_that_pass_together_wait_for_each_other():
    office = Office()
    office.goal("boss")
    office.command("first", "boss")
    office.command("A", "boss")
    office.command("B", "boss", 0, orders=[B.achieving.start.together_with(A.achieving.start)])
    assert not office.handling("A")
    assert not office.handling("B")
    assert office.tree.status("B").waiting_for == "command first to be achieved"
    office.done("first")
    assert office.handling("A", "B")


def test_what_was_to_pass_together_with_a_killed_task_passes_without_it():
    office = Office()
    office.goal("boss")
    office.prepare("A", parent="boss")
    office.command("B", "boss", 0, orders=[B.achieving.start.together_with(A.achieving.start)])
    assert not office.handling("B")
    office.apply(KillRequested, "A", "not wanted any more")
    assert office.handling("B")


def test_points_that_pass_together_may_be_ordered_but_not_strictly():
    office = Office()
    office.goal("boss")
    office.prepare("A", parent="boss")
    office.prepare("B", parent="boss")
    office.constrain(A.achieving.start.together_with(B.achieving.start))
    office.constrain(A.achieving.start <= B.achieving.start)
    with pytest.raises(RefusedError, match="points come in order"):
        office.constrain(A.achieving.start < B.achieving.start)
    with pytest.raises(RefusedError, match="points come in order"):
        office.constrain(A.achieving.start + 1.0 <= B.achieving.start)
    office.command("A", "boss", 0)
    assert not office.handling("A")
    office.command("B", "boss", 0)
    assert office.handling("A", "B")


def test_a_delay_is_counted_from_the_earlier_point():
    office = Office()
    office.command("A", sender="you")
    office.command("B", flags=0, orders=[A.achieving.end + 5.0 <= B.achieving.start])
    office.done("A")
    ended = office.last["A"].ended or 0.0
    assert office.tree.status("B").waiting_for == f"the time {ended + 5.0:.1f}"
    assert office.wake() == ended + 5.0
    assert office.handling("B")


def test_a_delay_after_what_has_passed_is_what_is_left_of_it():
    office = Office()
    office.command("A", sender="you")
    began = office.tree.node("A").passed[Point.START_ACHIEVING]
    office.command("B", flags=0, orders=[A.achieving.start + 60.0 <= B.achieving.start])
    assert office.wake() == began + 60.0
    assert office.handling("B")


def test_a_point_waits_for_a_time_of_the_clock():
    office = Office()
    office.command("A", flags=0, orders=[A.achieving.start >= 1000.0])
    assert office.tree.status("A").waiting_for == "the time 1000.0"
    assert office.wake() == 1000.0
    assert office.handling("A")


def test_a_time_that_has_passed_holds_nothing():
    office = Office()
    office.command("A", flags=0, orders=[A.achieving.start >= 0.5])
    assert office.handling("A")


def test_what_waits_for_a_killed_task_is_let_go():
    office = Office()
    office.command("A", sender="you")
    office.command("B", flags=0, orders=[A.achieving.end <= B.achieving.start])
    office.apply(KillRequested, "A", "no more")
    office.stop("A")
    assert office.handling("B")


def test_a_constraint_on_what_has_passed_holds_nothing_and_on_what_passed_first_is_refused():
    office = Office()
    office.command("A", sender="you")
    office.prepare("B")
    office.constrain(A.achieving.start <= B.achieving.start)
    with pytest.raises(RefusedError, match="start of achievement of A has passed already"):
        office.constrain(B.achieving.start <= A.achieving.start)
    office.command("B", flags=0)
    assert office.handling("B")


@pytest.mark.parametrize(
    ("flags", "points"),
    [
        (S, (Point.END_ACHIEVING, Point.START_ACHIEVING)),
        (P, (Point.END_PLANNING, Point.START_PLANNING)),
    ],
)
def test_a_sequence_is_what_the_flags_say(flags, points):
    office = Office()
    office.goal("boss")
    office.goal("A", "boss")
    office.goal("B", "boss", flags)
    a, b = office.tree.node("A"), office.tree.node("B")
    office.done("boss")
    assert points[1] not in b.passed
    finish(office)
    assert a.passed[points[0]] <= b.passed[points[1]]


def test_plan_first_and_delay_planning_are_what_they_say():
    office = Office()
    office.goal("A", flags=F, sender="you")
    office.goal("B", flags=D)
    a, b = office.tree.node("A"), office.tree.node("B")
    finish(office)
    assert a.passed[Point.END_PLANNING] <= a.passed[Point.START_ACHIEVING]
    assert b.passed[Point.START_PLANNING] == b.passed[Point.START_ACHIEVING]


def test_constraints_that_say_nothing_are_no_constraints():
    with pytest.raises(ValueError, match="a point cannot be before itself"):
        A.achieving.end <= A.achieving.end  # noqa: B015
    with pytest.raises(ValueError, match="first \\+ seconds <= then"):
        A.achieving.end <= B.achieving.start + 1.0  # noqa: B015
    with pytest.raises(ValueError, match="either a point or"):
        Order(then=A.achieving.end.ref)


@pytest.mark.bus
async def test_constraints_order_tasks_of_different_senders(
    user: Module, robot: Robot, options: BusOptions
):
    async with Module("other", options=options) as other:
        await other.wait_for(Step, timeout=10.0)
        late = await user.prepare(Step)
        early = await other.prepare(Step)
        assert await user.constrain(early.achieving.end <= late.achieving.start) == 1
        with pytest.raises(RefusedError, match=f"end of achievement of {late.id}"):
            await user.constrain(late.achieving.end <= early.achieving.start)
        second = await user.execute(Step(name="late"), id=late.id)
        assert second.status.state == "inactive"
        first = await other.execute(Step(name="early"), id=early.id)
        await second.result(timeout=10.0)
        await first.result(timeout=10.0)
    assert robot.done == ["early", "late"]


@pytest.mark.bus
async def test_a_task_waits_for_a_time_and_for_a_delay(user: Module, robot: Robot):
    first = await user.execute(Step(name="a"))
    ref = await user.prepare(Step)
    delayed = first.achieving.end + 0.2 <= ref.achieving.start
    second = await user.execute(Step(name="b"), id=ref.id, orders=[delayed])
    await second.result(timeout=10.0)
    await first.result(timeout=10.0)
    assert first.status.ended is not None
    assert second.status.started is not None
    assert second.status.started >= first.status.ended + 0.2


def test_what_waits_together_with_a_place_says_who_has_to_send_it():
    office = Office()
    office.goal("G")
    place = office.prepare("P", parent="G")
    office.command("C", "G", 0)
    office.goal("H", "G", 0)
    office.command("D", "H", 0)
    office.constrain(TaskRef("D").achieving.end.together_with(TaskRef("C").achieving.end))
    office.constrain(TaskRef("C").achieving.end.together_with(place.achieving.end))
    office.done("D")
    words = office.last["D"].waiting_for
    assert words == "command C to be achieved, me to send command P"


def test_a_task_that_is_handled_says_what_its_end_waits_for():
    office = Office()
    office.command("first", flags=0)
    office.goal("A", flags=0)
    office.command("a1", "A")
    office.constrain(TaskRef("first").achieving.end <= A.achieving.end)
    office.done("A")
    assert office.last["A"].waiting_for == "command first to be achieved"
    office.done("first")
    assert office.last["A"].waiting_for == "what is below it to end"
    office.done("a1")
    assert office.state("A") is TaskState.ACHIEVED


def test_what_cannot_begin_before_a_place_is_filled_says_so():
    office = Office()
    office.goal("G")
    place = office.prepare("P", parent="G")
    held = [office.prepare(id, parent="G") for id in ("Q", "R")]
    office.constrain(held[1].achieving.start.together_with(held[0].achieving.start))
    office.constrain(held[0].achieving.start.together_with(place.achieving.start))
    for id in ("R", "Q"):
        office.command(id, "G", 0)
    assert office.state("R") is TaskState.INACTIVE
    assert "me to send command P" in (office.last["R"].waiting_for or "")
    office.command("P", "G", 0)
    assert office.handling("P", "Q", "R")
