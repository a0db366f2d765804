"""What the task tree does for modules: exceptions, monitors, taps, constraints, clean-ups."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from typing import Any

import pytest

from tca_bus import (
    BusOptions,
    Command,
    Condition,
    ConfigError,
    Constraint,
    Demon,
    ExceptionContext,
    Goal,
    HandlerFailedError,
    KilledError,
    Module,
    MonitorContext,
    Query,
    RefusedError,
    TapNotice,
    TaskContext,
    TaskError,
    TaskFailedError,
    TcaException,
    catch,
    clean_up,
    tap,
)
from tca_bus.testing import bus, central, eventually

pytestmark = pytest.mark.bus


class Blocked(TcaException):
    """Something is in the way."""

    place: str = ""


class DoorBlocked(Blocked):
    """A door is closed."""

    door: str = ""


class Fetch(Goal[str]):
    """Get a thing."""

    what: str


class Step(Command[str]):
    """Do one thing."""

    name: str
    fails: bool = False


class Open(Command[None]):
    """Open a door."""

    door: str


class Stop(Command[None]):
    """Stop the wheels."""


class Low(Query[Condition]):
    """Whether the battery is low."""

    limit: float


class Watch(Demon):
    """Watch the door."""

    door: str


class Charge(Command[None]):
    """Go to the charger."""

    volts: float = 0.0


class Approve(TapNotice, Command[None]):
    """Say whether a step may be done."""


class Hear(Command[None]):
    """Hear of a step, by its own data."""

    name: str
    fails: bool = False


@dataclass
class Robot:
    """A module that notes what it does."""

    module: Module
    done: list[str] = field(default_factory=list)
    volts: float = 12.0
    steps_fail: int = 0
    hold: asyncio.Event = field(default_factory=asyncio.Event)
    notices: list[Approve] = field(default_factory=list)
    refuse: bool = False

    def serve(self) -> None:
        module = self.module
        module.serve(Step, self.step, capacity=5)
        module.serve(Open, self.open)
        module.serve(Stop, self.stop)
        module.serve(Low, self.low)
        module.serve(Watch, self.watch)
        module.serve(Charge, self.charge, capacity=5)
        module.serve(Approve, self.approve)
        module.serve(Hear, self.hear, capacity=5)
        module.serve(Fetch, self.fetch, capacity=5)

    async def fetch(self, goal: Fetch, ctx: TaskContext) -> str:
        for part in goal.what.split("+"):
            await ctx.execute(Step(name=part))
        return goal.what

    async def step(self, step: Step, _: TaskContext) -> str:
        self.done.append(step.name)
        if step.name.startswith("wait"):
            await self.hold.wait()
        if step.fails or (step.name == "door" and self.steps_fail > 0):
            self.steps_fail -= 1
            raise TaskError(DoorBlocked(door="r-5313", place="corridor"))
        return step.name

    async def open(self, order: Open, _: TaskContext) -> None:
        self.done.append(f"open {order.door}")

    async def stop(self, _: Stop, __: TaskContext) -> None:
        self.done.append("stop")

    async def low(self, question: Low, _: Any) -> Condition:
        return Condition(satisfied=self.volts < question.limit, data={"volts": self.volts})

    async def watch(self, watch: Watch, ctx: MonitorContext) -> None:
        while await ctx.fire(volts=1.0):
            self.done.append(f"saw {watch.door}")

    async def charge(self, order: Charge, _: TaskContext) -> None:
        self.done.append(f"charge {order.volts:g}")

    async def approve(self, notice: Approve, _: TaskContext) -> None:
        self.notices.append(notice)
        if self.refuse:
            raise TaskError("refused", "not now")
        self.done.append(f"approve {notice.data['name']}")

    async def hear(self, heard: Hear, _: TaskContext) -> None:
        self.done.append(f"hear {heard.name}")


@pytest.fixture
async def options() -> AsyncIterator[BusOptions]:
    async with bus() as options, central(options):
        yield options


@pytest.fixture
async def robot(options: BusOptions) -> AsyncIterator[Robot]:
    module = Module("robot", options=options)
    robot = Robot(module)
    robot.serve()
    async with module:
        yield robot


@pytest.fixture
async def user(options: BusOptions, robot: Robot) -> AsyncIterator[Module]:
    async with Module("user", options=options) as module:
        await module.wait_for(Step, Fetch, timeout=10.0)
        yield module


async def test_an_exception_handler_repairs_a_failure_below(user: Module, robot: Robot):
    seen: list[tuple[str, str, int]] = []

    @robot.module.exception_handler(Blocked, name="openIt")
    async def open_it(problem: Blocked, ctx: ExceptionContext) -> str:
        seen.append((problem.place, ctx.caught.failed_name, ctx.caught.retries))
        await ctx.execute(Open(door=(ctx.failure.data or {})["door"]))
        return "opened"

    await user.wait_for("openIt", timeout=5.0)
    robot.steps_fail = 1
    task = await user.expand(Fetch(what="go+door+back"), attach=[catch(Blocked, by="openIt")])
    assert await task.result(timeout=10.0) == "go+door+back"
    assert seen == [("corridor", "step", 0)]
    assert robot.done == ["go", "door", "open r-5313", "back"]


async def test_a_handler_has_the_failed_task_tried_again_but_not_for_ever(
    user: Module, robot: Robot
):
    @robot.module.exception_handler(DoorBlocked, name="again")
    async def again(_: DoorBlocked, ctx: ExceptionContext) -> None:
        ctx.retry_failed(most=2)

    await user.wait_for("again", timeout=5.0)
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
    await user.wait_for("outer", "old", "new", "inner", timeout=5.0)
    catches = [catch(by="outer"), catch(by="old"), catch(by="new")]
    async with await user.attach(catch(by="inner"), to=Step):
        robot.steps_fail = 1
        task = await user.expand(Fetch(what="door"), attach=[*catches])
        assert await task.result(timeout=10.0) == "door"
    assert order == ["inner", "new", "old", "outer"]


async def test_a_handler_may_raise_another_failure(user: Module, robot: Robot):
    @robot.module.exception_handler(Blocked, name="giveUp")
    async def give_up(_: Blocked, __: ExceptionContext) -> None:
        raise TaskError("no_way", "there is no other way")

    await user.wait_for("giveUp", timeout=5.0)
    task = await user.expand(Fetch(what="x"), attach=[catch(Blocked, by="giveUp")])
    await task.result(timeout=10.0)
    robot.steps_fail = 1
    task = await user.expand(Fetch(what="door"), attach=[catch(Blocked, by="giveUp")])
    with pytest.raises(TaskFailedError) as failed:
        await task.result(timeout=10.0)
    names = [link.name for link in failed.value.failure.chain()]
    assert names == ["child_failed", "no_way", "doorBlocked"]


async def test_invocations_of_a_handler_are_capped(user: Module, robot: Robot):
    @robot.module.exception_handler(Blocked, name="once")
    async def once(_: Blocked, __: ExceptionContext) -> str:
        robot.done.append("once")
        return "repaired"

    await user.wait_for("once", timeout=5.0)
    async with await user.attach(catch(Blocked, by="once", max_invocations=1), to=Step):
        first = await user.execute(Step(name="a", fails=True))
        assert await first.result(timeout=10.0) == "repaired"
        second = await user.execute(Step(name="b", fails=True))
        with pytest.raises(TaskFailedError):
            await second.result(timeout=10.0)
    assert robot.done == ["a", "once", "b"]


async def test_a_failure_that_need_not_matter_lets_the_rest_go_on(user: Module, robot: Robot):
    class Tour(Goal[None]):
        """Steps of which some may fail."""

    async def tour(_: Tour, ctx: TaskContext) -> None:
        await ctx.execute(Step(name="a", fails=True), on_unhandled="go_on")
        await ctx.execute(Step(name="b"))

    robot.module.serve(Tour, tour)
    await user.wait_for(Tour, timeout=5.0)
    await (await user.expand(Tour())).result(timeout=10.0)
    assert robot.done == ["a", "b"]


async def test_a_polling_monitor_acts_while_its_parent_is_under_way(user: Module, robot: Robot):
    class Patrol(Goal[int]):
        """Walk until told, watching the battery."""

    async def patrol(_: Patrol, ctx: TaskContext) -> int:
        watch = await ctx.monitor(Low(limit=11.0), then=Charge(volts=1.0), every=0.01, most=2)
        robot.volts = 10.5
        report = await watch.result(timeout=10.0)
        await ctx.monitor(Low(limit=1.0), then=Charge(), every=0.01)
        return report.fired

    robot.module.serve(Patrol, patrol)
    await user.wait_for(Patrol, timeout=5.0)
    assert await (await user.expand(Patrol())).result(timeout=10.0) == 2
    assert robot.done == ["charge 10.5"] * 2


async def test_a_point_monitor_tests_once_at_its_place(user: Module, robot: Robot):
    class Trip(Goal[None]):
        """A step, a test, a step."""

    async def trip(_: Trip, ctx: TaskContext) -> None:
        await ctx.execute(Step(name="a"))
        await ctx.test(Low(limit=20.0), then=Charge(volts=1.0))
        await ctx.test(Low(limit=1.0), then=Charge(volts=1.0))
        await ctx.execute(Step(name="b"))

    robot.module.serve(Trip, trip)
    await user.wait_for(Trip, timeout=5.0)
    await (await user.expand(Trip())).result(timeout=10.0)
    assert robot.done == ["a", "charge 12", "b"]


async def test_a_demon_fires_each_nth_time_and_at_most_so_often(user: Module, robot: Robot):
    watch = await user.monitor(Watch(door="r-5313"), then=Charge(volts=2.0), fire_every=2, most=2)
    report = await watch.result(timeout=10.0)
    assert (report.satisfied, report.fired) == (4, 2)
    assert robot.done.count("charge 1") == 2
    assert robot.done.count("saw r-5313") == 3


async def test_a_blocking_tap_holds_the_task_until_the_listener_is_done(user: Module, robot: Robot):
    async with await user.attach(tap("BeforeHandling", Approve), to=Step):
        await (await user.execute(Step(name="a"))).result(timeout=10.0)
    await (await user.execute(Step(name="b"))).result(timeout=10.0)
    assert robot.done == ["approve a", "a", "b"]
    assert robot.notices[0].message == "step"


async def test_an_interlock_that_refuses_fails_what_it_holds(user: Module, robot: Robot):
    robot.refuse = True
    async with await user.attach(tap("BeforeHandling", Approve, on_failure="fail"), to=Step):
        task = await user.execute(Step(name="a"))
        with pytest.raises(TaskFailedError) as failed:
            await task.result(timeout=10.0)
    assert [link.name for link in failed.value.failure.chain()] == ["tap_failed", "refused"]
    assert robot.done == []


async def test_a_tap_gives_its_listener_the_data_of_what_is_tapped(user: Module, robot: Robot):
    async with await user.attach(tap("AfterSuccess", Hear), to=Step):
        await (await user.execute(Step(name="a"))).result(timeout=10.0)
        await eventually(lambda: "hear a" in robot.done)


async def test_taps_that_make_no_sense_are_refused(user: Module):
    with pytest.raises(ConfigError, match="BeforeHandling"):
        tap("BeforeHandlin", Hear)
    with pytest.raises(ConfigError, match="a goal, a command, an inform"):
        tap("WhenSent", Low)


async def test_a_clean_up_runs_when_a_task_is_killed_and_spares_one_that_succeeds(
    user: Module, robot: Robot
):
    fine = await user.execute(Step(name="a"), attach=[clean_up(Stop())])
    await fine.result(timeout=10.0)
    task = await user.execute(Step(name="wait"), attach=[clean_up(Stop())])
    await eventually(lambda: "wait" in robot.done)
    await task.kill("changed my mind")
    with pytest.raises(KilledError):
        await task.result(timeout=10.0)
    assert robot.done == ["a", "wait", "stop"]


async def test_constraints_order_tasks_of_different_senders(
    user: Module, robot: Robot, options: BusOptions
):
    async with Module("other", options=options) as other:
        await other.wait_for(Step, timeout=5.0)
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


async def test_a_task_waits_for_a_time_and_for_a_delay(user: Module, robot: Robot):
    first = await user.execute(Step(name="a"))
    ref = await user.prepare(Step)
    delayed = first.achieving.end + 0.2 <= ref.achieving.start
    second = await user.execute(Step(name="b"), id=ref.id, orders=[delayed])
    await second.result(timeout=10.0)
    gap = (second.status.started or 0.0) - (first.status.ended or 0.0)
    assert gap >= 0.19 or first.status.ended is None


async def test_a_suspended_task_waits_and_is_resumed(user: Module, robot: Robot):
    task = await user.expand(Fetch(what="wait1+b"))
    await eventually(lambda: "wait1" in robot.done)
    status = await user.suspend(task)
    assert status.suspended
    robot.hold.set()
    await eventually(lambda: task.status.state in {"handled", "planned"})
    assert "b" not in robot.done
    await user.resume(task)
    await task.result(timeout=10.0)
    assert robot.done == ["wait1", "b"]


async def test_what_waits_is_put_in_order_again(user: Module, robot: Robot):
    class Slow(Command[None]):
        """One at a time."""

        name: str

    async def slow(order: Slow, _: TaskContext) -> None:
        robot.done.append(order.name)
        await robot.hold.wait()

    robot.module.serve(Slow, slow)
    await user.wait_for(Slow, timeout=5.0)
    free = Constraint.NONE
    tasks = [await user.execute(Slow(name=name), constraints=free) for name in "abc"]
    await eventually(lambda: robot.done == ["a"])
    await user.prioritize(tasks[2], 5)
    robot.hold.set()
    for task in tasks:
        await task.result(timeout=10.0)
    assert robot.done == ["a", "c", "b"]


async def test_a_deadline_fails_a_task_by_name(user: Module, robot: Robot):
    task = await user.execute(Step(name="wait"), within=0.1)
    with pytest.raises(TaskFailedError, match=r"not achieved within 0\.1 s") as failed:
        await task.result(timeout=10.0)
    assert failed.value.failure.name == "deadline_passed"


async def test_a_postponed_answer_ends_the_task_when_it_comes(user: Module, robot: Robot):
    class Ask(Command[str]):
        """Answered later."""

    asked: list[str] = []

    async def ask(_: Ask, ctx: TaskContext) -> None:
        ctx.postpone()
        asked.append(ctx.id)

    robot.module.serve(Ask, ask, capacity=2)
    await user.wait_for(Ask, timeout=5.0)
    task = await user.execute(Ask())
    await eventually(lambda: asked)
    assert not task.status.is_ended
    await eventually(lambda: not _is_answered(robot.module, asked[0], "later"))
    assert await task.result(timeout=10.0) == "later"
    with pytest.raises(TaskError, match="waits for no answer"):
        robot.module.answer(asked[0], "again")


def _is_answered(module: Module, task: str, result: str) -> bool:
    try:
        module.answer(task, result)
    except TaskError:
        return True
    return False


async def test_a_handler_that_does_not_stop_is_abandoned(user: Module, robot: Robot):
    class Stubborn(Command[None]):
        """Does not listen."""

        grace = 0.2

    async def stubborn(_: Stubborn, __: TaskContext) -> None:
        robot.done.append("stubborn")
        while not robot.hold.is_set():
            try:
                await robot.hold.wait()
            except asyncio.CancelledError:
                robot.done.append("ignored")

    robot.module.serve(Stubborn, stubborn)
    await user.wait_for(Stubborn, timeout=5.0)
    task = await user.execute(Stubborn())
    await eventually(lambda: "stubborn" in robot.done)
    await task.kill("enough")
    with pytest.raises(KilledError):
        await task.result(timeout=10.0)
    assert robot.done == ["stubborn", "ignored"]
    robot.hold.set()


async def test_walks_find_relatives_by_place_and_by_name(user: Module, robot: Robot):
    task = await user.expand(Fetch(what="wait1+b"))
    await eventually(lambda: "wait1" in robot.done)
    first = await user.relative(task, "first_child")
    following = await user.relative(first.id, "next")
    assert [first.data["name"], following.data["name"]] == ["wait1", "b"]
    assert (await user.relative(first.id, "parent")).id == task.id
    assert (await user.relative(following.id, "previous")).id == first.id
    assert (await user.relative(following.id, "ancestor", name="fetch")).id == task.id
    assert await user.relative(task, "child", name="nothing") is None
    with pytest.raises(HandlerFailedError, match="no task 'nobody'"):
        await user.relative("nobody", "parent")
    robot.hold.set()
    await task.result(timeout=10.0)


async def test_a_task_held_for_its_module_goes_on_when_that_is_back(
    user: Module, options: BusOptions
):
    class Keep(Command[str]):
        """Only its own module may do it."""

        on_module_lost = "hold"

    async def serve(module: Module, answer: str, gate: asyncio.Event) -> None:
        async def keep(_: Keep, __: TaskContext) -> str:
            await gate.wait()
            return answer

        module.serve(Keep, keep)

    gate = asyncio.Event()
    first = Module("keeper", options=options)
    await serve(first, "first", gate)
    async with first:
        await user.wait_for(Keep, timeout=5.0)
        task = await user.execute(Keep())
        await eventually(lambda: task.status.state == "active")
    gate.set()
    stranger = Module("stranger", options=options)
    await serve(stranger, "stranger", gate)
    async with stranger:
        await eventually(lambda: "keeper" in (task.status.waiting_for or ""), timeout=15.0)
        again = Module("keeper", options=options)
        await serve(again, "again", gate)
        async with again:
            assert await task.result(timeout=15.0) == "again"
