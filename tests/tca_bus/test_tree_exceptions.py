"""Exceptions (tca.md 3.8 and 4.2): the search up the tree, retry, bypass, and what is uncaught."""

from __future__ import annotations

import pytest
from tree_office import Office
from tree_robot import Blocked, DoorBlocked, Fetch, Open, Robot, Step

from tca_bus import (
    Catch,
    ExceptionContext,
    Goal,
    Module,
    Resolution,
    TaskContext,
    TaskError,
    TaskFailedError,
    TaskState,
    TcaException,
    catch,
)
from tca_bus.tasktree import (
    Deregistered,
    KillRequested,
    ProviderLost,
    Submitted,
    UncaughtFailure,
)

BYPASS = Resolution(action="bypass")


def handler(id: str, *, by: str = "fix", exception: str = "*", most: int = 0, **facts) -> Catch:
    return Catch(id=id, exception=exception, handler=by, max_invocations=most, **facts)


def plan(office: Office, **facts) -> None:
    """A, below it B, below that the command E1; A and B have been handled."""
    office.goal("A", **facts)
    office.goal("B", "A")
    office.command("E1", "B")
    office.done("B")
    office.done("A")


def handlers_of(office: Office) -> list[str]:
    """The handlers that were invoked, in order, by the ids of their catches."""
    made = [event for event in office.records if isinstance(event, Submitted)]
    return [str(event.origin.attachment) for event in made if event.origin.role == "recovery"]


def names(office: Office, id: str) -> list[str]:
    failure = office.last[id].failure
    return [link.name for link in failure.chain()] if failure else []


def test_three_bypasses_end_in_uncaught_and_then_the_tree_ends():
    office = Office()
    plan(office)
    for id in ("A", "B", "E1"):
        office.attach(id, handler(f"on {id}".replace(" ", "-")))
    office.fail("E1", "stuck")
    for _ in range(3):
        (recovery,) = office.sent("fix")
        office.done(recovery, resolution=BYPASS)
    assert handlers_of(office) == ["on-E1", "on-B", "on-A"]
    uncaught = [event.id for event in office.records if isinstance(event, UncaughtFailure)]
    assert uncaught == ["E1"]
    assert names(office, "A") == ["child_failed", "child_failed", "stuck"]
    assert {id: office.state(id) for id in ("E1", "B", "A")} == dict.fromkeys(
        ("E1", "B", "A"), TaskState.FAILED
    )
    assert len(office.tree) == 0


def test_three_bypasses_of_what_may_fail_alone_let_the_tree_complete_as_in_tcm():
    office = Office()
    office.goal("A", attachments=[handler("on-A")])
    office.goal("B", "A", attachments=[handler("on-B")])
    office.command("E1", "B", attachments=[handler("on-E1")], on_unhandled="go_on")
    office.command("E2", "B")
    office.done("B")
    office.done("A")
    office.fail("E1")
    for _ in range(3):
        office.done(office.sent("fix")[0], resolution=BYPASS)
    assert office.state("E1") is TaskState.FAILED
    office.done("E2")
    assert office.state("A") is TaskState.ACHIEVED


def test_the_exception_comes_before_the_end_of_what_failed():
    office = Office()
    plan(office)
    office.attach("A", handler("c"))
    office.fail("E1")
    (recovery,) = office.sent("fix")
    assert office.tree.status(recovery).parent == "E1"
    assert office.tree.status(recovery).task_class == "exception"
    assert not office.last["E1"].is_ended
    assert office.tree.status("E1").waiting_for == "fix to deal with broken"
    assert not office.last["B"].is_ended


def test_siblings_are_released_before_their_parent_is_handled_and_a_failure_keeps_them():
    office = Office()
    office.goal("A", attachments=[handler("c")])
    office.goal("B", "A")
    office.goal("C", "A")
    office.goal("D", "A", 1 | 8)
    assert office.handling("A", "B", "C")
    assert office.state("D") is TaskState.INACTIVE
    office.fail("B")
    assert office.handling("C")
    assert office.state("D") is TaskState.INACTIVE
    office.done(office.sent("fix")[0])
    office.done("C")
    assert office.handling("D")


def test_a_repair_makes_the_failed_task_done_with_what_was_added():
    office = Office()
    plan(office)
    office.attach("A", handler("c"))
    office.fail("E1")
    (recovery,) = office.sent("fix")
    office.command("more", recovery)
    office.done(recovery, result="by another way")
    assert not office.last["E1"].is_ended
    office.done("more")
    assert office.last["E1"].state is TaskState.ACHIEVED
    assert office.last["E1"].result == "by another way"
    assert office.state("A") is TaskState.ACHIEVED


def test_on_one_task_the_newest_is_first_and_those_on_its_message_are_last():
    office = Office()
    office.register("command", handler("message-1"))
    office.register("command", handler("message-2"))
    plan(office)
    office.attach("E1", handler("own-1"))
    office.attach("E1", handler("own-2"))
    office.attach("B", handler("above"))
    office.fail("E1")
    for _ in range(5):
        office.done(office.sent("fix")[0], resolution=BYPASS)
    assert handlers_of(office) == ["own-2", "own-1", "message-2", "message-1", "above"]
    assert office.state("A") is TaskState.FAILED


def test_a_failure_is_taken_by_its_name_or_a_base_of_it():
    office = Office()
    plan(office)
    office.attach("A", handler("base", exception="blocked"))
    office.attach("A", handler("other", exception="lowBattery"))
    office.fail("E1", "doorBlocked", kinds=("doorBlocked", "blocked"))
    assert handlers_of(office) == ["base"]


def test_a_handler_is_not_invoked_while_it_is_at_work():
    office = Office()
    plan(office)
    office.attach("A", handler("outer", by="other"))
    office.attach("B", handler("inner"))
    office.fail("E1", "stuck")
    (recovery,) = office.sent("fix")
    office.command("try", recovery)
    office.fail("try", "again_stuck")
    assert handlers_of(office) == ["inner", "outer"]
    office.done(office.sent("other")[0])
    office.done(recovery)
    assert office.state("A") is TaskState.ACHIEVED


def test_a_handler_that_fails_replaces_the_failure_and_keeps_it_as_the_cause():
    office = Office()
    plan(office)
    office.attach("B", handler("c"))
    office.fail("E1", "stuck")
    office.fail(office.sent("fix")[0], "no_way")
    assert names(office, "E1") == ["no_way", "stuck"]
    assert names(office, "A") == ["child_failed", "child_failed", "no_way", "stuck"]


def test_a_handler_that_is_lost_is_passed_over():
    office = Office()
    office.appear("helper", "h1")
    plan(office)
    office.attach("A", handler("outer", by="other"))
    office.attach("B", handler("inner"))
    office.fail("E1", "stuck")
    (recovery,) = office.sent("fix")
    holder = office.tree.node(recovery).incarnation
    assert holder is not None
    office.apply(ProviderLost, holder)
    assert handlers_of(office) == ["inner", "outer"]


def test_a_retry_is_counted_and_has_an_end():
    office = Office()
    plan(office)
    office.attach("A", handler("c"))
    again = Resolution(action="retry", most=2)
    for retries in (1, 2):
        office.fail("E1")
        office.done(office.sent("fix")[0], resolution=again)
        assert office.handling("E1")
        assert (office.last["E1"].retries, office.last["E1"].attempt) == (retries, retries + 1)
    office.fail("E1", "for_good")
    office.done(office.sent("fix")[0], resolution=again)
    assert names(office, "A") == ["child_failed", "child_failed", "for_good"]


def test_a_retry_of_the_context_begins_there_again():
    office = Office()
    office.goal("A", attachments=[handler("c")])
    office.command("E1", "A")
    office.command("E2", "A", 0)
    office.done("A")
    office.fail("E1")
    again = Resolution(action="retry", task="A", most=1)
    office.done(office.sent("fix")[0], resolution=again)
    assert office.tree.status("A").waiting_for == "what is below it to end"
    office.stop("E2")
    assert office.handling("A")
    assert office.state("E1") is office.state("E2") is TaskState.KILLED
    office.done("A")
    assert office.state("A") is TaskState.ACHIEVED


def test_a_retry_of_something_else_is_a_bypass():
    office = Office()
    plan(office)
    office.command("Z", flags=0)
    office.attach("B", handler("c"))
    office.fail("E1")
    stray = Resolution(action="retry", task="Z")
    office.done(office.sent("fix")[0], resolution=stray)
    assert office.state("A") is TaskState.FAILED
    assert office.last["Z"].attempt == 1


def test_invocations_are_counted_over_all_tasks():
    office = Office()
    office.register("command", handler("c", most=2))
    for number in range(3):
        office.command(f"E{number}", flags=0)
        office.fail(f"E{number}")
        if office.sent("fix"):
            office.done(office.sent("fix")[0])
    states = [office.state(f"E{number}") for number in range(3)]
    assert states == [TaskState.ACHIEVED, TaskState.ACHIEVED, TaskState.FAILED]


def test_handlers_come_and_go_while_everything_runs():
    office = Office()
    plan(office)
    office.register("goal", handler("c"))
    office.apply(Deregistered, "c")
    office.register("goal", handler("d", owner="helper", incarnation="h1"))
    office.appear("helper", "h1")
    office.apply(ProviderLost, "h1")
    office.fail("E1")
    assert handlers_of(office) == []
    assert office.state("A") is TaskState.FAILED


def test_a_failure_is_offered_to_each_handler_once_on_its_way_up():
    office = Office()
    plan(office)
    office.attach("A", handler("c"))
    office.fail("E1")
    office.done(office.sent("fix")[0], resolution=BYPASS)
    assert handlers_of(office) == ["c"]
    assert office.state("A") is TaskState.FAILED


def test_a_kill_ends_what_fails_and_the_handler_at_work():
    office = Office()
    plan(office)
    office.attach("A", handler("c"))
    office.fail("E1")
    (recovery,) = office.sent("fix")
    office.apply(KillRequested, "A", "enough")
    assert office.last[recovery].existence == "terminating"
    office.stop(recovery)
    assert office.state("A") is office.state("E1") is TaskState.KILLED
    assert len(office.tree) == 0


@pytest.mark.bus
async def test_an_exception_handler_repairs_a_failure_below(user: Module, robot: Robot):
    seen: list[tuple[str, str, int]] = []

    @robot.module.exception_handler(Blocked, name="openIt")
    async def open_it(problem: Blocked, ctx: ExceptionContext) -> str:
        seen.append((problem.place, ctx.caught.failed_name, ctx.caught.retries))
        await ctx.execute(Open(door=(ctx.failure.data or {})["door"]))
        return "opened"

    await user.wait_for("openIt", timeout=10.0)
    robot.steps_fail = 1
    task = await user.expand(Fetch(what="go+door+back"), attach=[catch(Blocked, by="openIt")])
    assert await task.result(timeout=10.0) == "go+door+back"
    assert seen == [("corridor", "step", 0)]
    assert robot.done == ["go", "door", "open r-5313", "back"]


@pytest.mark.bus
async def test_a_handler_has_the_failed_task_tried_again_but_not_for_ever(
    user: Module, robot: Robot
):
    @robot.module.exception_handler(DoorBlocked, name="again")
    async def again(_: DoorBlocked, ctx: ExceptionContext) -> None:
        ctx.retry_failed(most=2)

    await user.wait_for("again", timeout=10.0)
    async with await user.attach(catch(DoorBlocked, by="again"), to=Fetch):
        robot.steps_fail = 2
        task = await user.expand(Fetch(what="door"))
        assert await task.result(timeout=10.0) == "door"
        assert robot.done == ["door"] * 3
        robot.steps_fail = 100
        task = await user.expand(Fetch(what="door"))
        with pytest.raises(TaskFailedError) as failed:
            await task.result(timeout=10.0)
    assert [link.name for link in failed.value.failure.chain()] == ["child_failed", "doorBlocked"]
    assert robot.done == ["door"] * 6


@pytest.mark.bus
async def test_bypasses_climb_and_the_newest_handler_is_first(user: Module, robot: Robot):
    order: list[str] = []

    def handler(name: str, *, takes: bool) -> None:
        @robot.module.exception_handler(TcaException, name=name)
        async def handle(_: TcaException, ctx: ExceptionContext) -> None:
            order.append(name)
            if not takes:
                ctx.bypass()

    for name, takes in (("outer", True), ("old", False), ("new", False), ("inner", False)):
        handler(name, takes=takes)
    await user.wait_for("outer", "old", "new", "inner", timeout=10.0)
    catches = [catch(by="outer"), catch(by="old"), catch(by="new")]
    async with await user.attach(catch(by="inner"), to=Step):
        robot.steps_fail = 1
        task = await user.expand(Fetch(what="door"), attach=[*catches])
        assert await task.result(timeout=10.0) == "door"
    assert order == ["inner", "new", "old", "outer"]


@pytest.mark.bus
async def test_a_handler_may_raise_another_failure(user: Module, robot: Robot):
    @robot.module.exception_handler(Blocked, name="giveUp")
    async def give_up(_: Blocked, __: ExceptionContext) -> None:
        raise TaskError("no_way", "there is no other way")

    await user.wait_for("giveUp", timeout=10.0)
    task = await user.expand(Fetch(what="x"), attach=[catch(Blocked, by="giveUp")])
    await task.result(timeout=10.0)
    robot.steps_fail = 1
    task = await user.expand(Fetch(what="door"), attach=[catch(Blocked, by="giveUp")])
    with pytest.raises(TaskFailedError) as failed:
        await task.result(timeout=10.0)
    names = [link.name for link in failed.value.failure.chain()]
    assert names == ["child_failed", "no_way", "doorBlocked"]


@pytest.mark.bus
async def test_invocations_of_a_handler_are_capped(user: Module, robot: Robot):
    @robot.module.exception_handler(Blocked, name="once")
    async def once(_: Blocked, __: ExceptionContext) -> str:
        robot.done.append("once")
        return "repaired"

    await user.wait_for("once", timeout=10.0)
    async with await user.attach(catch(Blocked, by="once", max_invocations=1), to=Step):
        first = await user.execute(Step(name="a", fails=True))
        assert await first.result(timeout=10.0) == "repaired"
        second = await user.execute(Step(name="b", fails=True))
        with pytest.raises(TaskFailedError):
            await second.result(timeout=10.0)
    assert robot.done == ["a", "once", "b"]


@pytest.mark.bus
async def test_a_failure_that_need_not_matter_lets_the_rest_go_on(user: Module, robot: Robot):
    class Tour(Goal[None]):
        """Steps of which some may fail."""

    async def tour(_: Tour, ctx: TaskContext) -> None:
        await ctx.execute(Step(name="a", fails=True), on_unhandled="go_on")
        await ctx.execute(Step(name="b"))

    robot.module.serve(Tour, tour)
    await user.wait_for(Tour, timeout=10.0)
    await (await user.expand(Tour())).result(timeout=10.0)
    assert robot.done == ["a", "b"]


@pytest.mark.bus
async def test_a_running_parent_that_waits_for_the_child_sees_the_failure_first(
    user: Module, robot: Robot
):
    class Careful(Goal[str]):
        """Deals with a failure itself."""

    async def careful(_: Careful, ctx: TaskContext) -> str:
        step = await ctx.execute(Step(name="a", fails=True))
        try:
            await step.result(timeout=10.0)
        except TaskFailedError as error:
            return f"without it: {error.failure.name}"
        return "with it"

    robot.module.serve(Careful, careful)
    await user.wait_for(Careful, timeout=10.0)
    task = await user.expand(Careful())
    assert await task.result(timeout=10.0) == "without it: doorBlocked"


@pytest.mark.bus
async def test_a_handler_has_the_facts_and_its_walks(user: Module, robot: Robot):
    told: dict[str, object] = {}

    @robot.module.exception_handler(Blocked, name="look")
    async def look(problem: Blocked, ctx: ExceptionContext) -> None:
        failed = await user.relative(ctx.id, "failed")
        top = await user.relative(ctx.id, "top_level")
        told.update(
            failed=failed.id if failed else None,
            top=top.id if top else None,
            ids=(ctx.failed.id, ctx.on.id),
            data=ctx.caught.failed_data["name"],
            door=(ctx.failure.data or {}).get("door"),
        )
        assert isinstance(problem, Blocked)

    await user.wait_for("look", timeout=10.0)
    robot.steps_fail = 1
    task = await user.expand(Fetch(what="door"), attach=[catch(Blocked, by="look")])
    await task.result(timeout=10.0)
    assert told["ids"] == (told["failed"], task.id)
    assert told["top"] == task.id
    assert (told["data"], told["door"]) == ("door", "r-5313")
