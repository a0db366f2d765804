"""Whole runs of the planner against a robot that answers at once."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator, Callable
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from rogue_fakes import NO_ANSWER, PLACES, FakeModule, ScriptedRobot, failed, make_request, typed

from navigate.messages import NavigateToGoal
from rogue import trace
from rogue.conversation import Conversation
from rogue.decisions import DecisionRecorder
from rogue.distances import Distances
from rogue.episode import Episode
from rogue.errands import Agenda, RankSum
from rogue.execution import (
    Executor,
    KnownWorld,
    Patience,
    StepRunner,
    TaskOfRobot,
    Urgency,
    as_published,
)
from rogue.explain import DecisionKind, Rival
from rogue.memory import Store
from rogue.messages import DeliveryRequest, RequestState
from rogue.outcomes import Outcome
from rogue.planning import Rules
from rogue.requests import RequestBook, load_directory
from tca_bus.testing import ManualClock

HERE = Path(__file__).parent
FAX = {"user": "jhm", "item": "deliverfax", "pickup": "r-5311", "rank": 8}
NODE_LINE = re.compile(r" *\d+ +n\d+ |Achieved")


@dataclass
class EventfulRobot(ScriptedRobot):
    """A robot during whose drives things happen: ``events`` by the number of the drive."""

    events: dict[int, Callable[[], object]] = field(default_factory=dict)

    async def perform(self, task_id: str, message: TaskOfRobot, urgency: Urgency) -> Outcome:
        if isinstance(message, NavigateToGoal):
            event = self.events.pop(self.count(NavigateToGoal), None)
            if event is not None:
                await event()
        return await super().perform(task_id, message, urgency)


@dataclass
class Scene:
    store: Store
    book: RequestBook
    robot: EventfulRobot
    episode: Callable[..., Episode]
    world: KnownWorld
    clock: ManualClock
    agenda: Agenda

    async def play(self, rules: Rules, *requests: DeliveryRequest) -> list[str]:
        """Run episodes until nothing is open; gives the lines."""
        for request in requests:
            await self.book.add(request, None)
        while waiting := self.book.open_requests():
            if all(map(self.world.waits, waiting)):
                due = self.world.next_due(waiting)
                assert due is not None
                await self.clock.advance(due - self.clock.now())
            await self.episode(rules).run()
        return [line.text for line in await self.store.lines(0, 10_000)]

    async def states(self) -> dict[str, str]:
        return {r.id: r.state.value for r in await self.store.requests()}


@pytest.fixture
async def scene(tmp_path: Path) -> AsyncIterator[Scene]:
    async with Store(tmp_path) as store:
        module, robot, directory = FakeModule(), EventfulRobot(), load_directory()
        book = RequestBook(module, store, directory)
        conversation = Conversation(module, store)
        world = KnownWorld(store, module)
        await world.load()
        executor = Executor(
            module=module,
            store=store,
            book=book,
            world=world,
            directory=directory,
            runner=StepRunner(robot, store, "cafe", conversation.tell_step),
            patience=Patience(),
            arrival=as_published(),
        )
        book.on_change = world.on_change = executor.reconsider

        told: set[str] = set()
        distances = Distances(module)
        agenda = Agenda.plain(distances)

        def episode(rules: Rules, level: int = 2) -> Episode:
            return Episode(
                rules=rules,
                locations={room: (x / 100, y / 100) for room, (x, y) in PLACES.items()},
                directory=directory,
                distances=distances,
                agenda=agenda,
                store=store,
                book=book,
                executor=executor,
                conversation=conversation,
                decisions=DecisionRecorder(store, module.clock),
                servable=lambda: [r for r in book.open_requests() if not world.waits(r)],
                told=told,
                level=level,
            )

        yield Scene(store, book, robot, episode, world, module.clock, agenda)


def nodes(lines: list[str]) -> list[str]:
    return [line for line in lines if NODE_LINE.match(line)]


async def test_the_conversation_of_figure_6(scene: Scene):
    request = make_request()
    lines = [trace.LISTENING, *await scene.play(Rules.NONE, request), trace.LISTENING]
    said = "\n".join(lines) + "\n"
    figure = (HERE / "figure6.txt").read_text()
    figure = figure.replace("{posted}", trace.show_time(request.posted))
    assert said == figure.replace("{deadline}", trace.show_deadline(request.deadline))


async def test_the_nodes_of_figure_9(scene: Scene):
    scene.robot.events[0] = lambda: scene.book.add(make_request("b", **FAX), None)
    lines = await scene.play(Rules.Y1996, make_request())
    assert nodes(lines) == (HERE / "figure9.txt").read_text().splitlines()


@pytest.mark.parametrize("rules", list(Rules))
async def test_all_rule_sets_bring_two_errands_to_their_end(scene: Scene, rules: Rules):
    await scene.play(rules, make_request(), make_request("b", **FAX))
    assert await scene.states() == {"a": "completed", "b": "completed"}
    assert (await scene.store.facts()).tray == frozenset()


async def test_after_a_failure_the_rest_goes_on(scene: Scene):
    scene.robot.answers = [typed("y"), typed("i")]
    lines = await scene.play(Rules.WORKING, make_request(), make_request("b", **FAX))
    assert sorted((await scene.states()).values()) == ["completed", "failed"]
    assert lines[-2:] == [trace.ACHIEVED, ""]
    assert sum("impossible" in line and "Request" in line for line in lines) == 1


async def test_a_failure_of_the_only_request_achieves_nothing(scene: Scene):
    scene.robot.drives = [failed("door_blocked")] * 9
    lines = await scene.play(Rules.WORKING, make_request())
    assert await scene.states() == {"a": "failed"}
    assert trace.ACHIEVED not in lines
    assert scene.robot.count(NavigateToGoal) == 1 + Patience().returns
    reason = (await scene.store.requests())[0].reason
    assert reason == "cannot get to r-5303, door_blocked: it was door_blocked, 3 times"


async def test_what_is_put_off_comes_after_the_rest(scene: Scene):
    scene.robot.drives = [failed("door_blocked")]
    await scene.play(Rules.WORKING, make_request(), make_request("b", **FAX))
    assert await scene.states() == {"a": "completed", "b": "completed"}
    finished = sorted(request.finished or 0.0 for request in await scene.store.requests())
    assert finished == [1000.0, 1000.0 + Patience().later]


async def test_where_nobody_answers_the_robot_comes_back_later(scene: Scene):
    scene.robot.answers = [typed("y"), *[NO_ANSWER] * Patience().asks]
    lines = await scene.play(Rules.NONE, make_request())
    assert await scene.states() == {"a": "completed"}
    assert sum("a is put off: acquire-item at r-5303, no_answer" in line for line in lines) == 1
    steps = [step.operator.split()[0] for step in await scene.store.steps_of("a")]
    assert steps == ["goto-pickup-loc", *["acquire-item"] * 2, "goto-deliver-loc", "deliver-item"]


@pytest.mark.parametrize("rules", list(Rules))
async def test_what_somebody_else_has_done_is_left_and_the_rest_goes_on(scene: Scene, rules: Rules):
    async def brought() -> None:
        request = scene.book.find("a")
        assert request is not None
        await scene.book.end(request, RequestState.COMPLETED, "somebody else brought it")

    scene.robot.events[0] = brought
    lines = await scene.play(rules, make_request(), make_request("b", **FAX))
    assert await scene.states() == {"a": "completed", "b": "completed"}
    assert "          Request a is completed: somebody else brought it" in lines
    done = [step.operator for step in await scene.store.steps_of("a") if step.state == "done"]
    assert not any("mitchell" in step for step in done if not step.startswith("goto"))


async def test_an_item_taken_on_the_way_is_fetched_again(scene: Scene):
    taken = ("mitchell", "delivermail")
    scene.robot.events[1] = lambda: scene.world.move_things(gone=[taken])
    await scene.play(Rules.WORKING, make_request())
    assert await scene.states() == {"a": "completed"}
    steps = [(s.operator.split()[0], s.state) for s in await scene.store.steps_of("a")]
    assert steps[2] == ("goto-deliver-loc", "failed")
    assert [name for name, _ in steps[3:]] == [
        "goto-pickup-loc",
        "acquire-item",
        "goto-deliver-loc",
        "deliver-item",
    ]


async def test_a_cancellation_under_way_drops_the_goal(scene: Scene):
    async def cancel() -> None:
        request = scene.book.find("a")
        assert request is not None
        await scene.book.end(request, RequestState.CANCELED, "not needed")

    scene.robot.events[1] = cancel
    await scene.play(Rules.WORKING, make_request(), make_request("b", **FAX))
    states = await scene.states()
    assert states == {"a": "canceled", "b": "completed"}


async def test_what_is_only_to_leave_the_tray_is_not_urgent_any_more(scene: Scene):
    seen: list[float] = []

    async def look() -> None:
        seen.append(scene.agenda.priority("mitchell", "delivermail"))

    async def cancel() -> None:
        await look()
        await scene.book.give_up("a", RequestState.CANCELED, "not needed", "deliver")

    fax = make_request("b", **FAX, deliver="r-5315")
    scene.robot.events = {1: cancel, 2: look}
    await scene.play(Rules.WORKING, make_request(deadline=1000.0), fax)
    hurry = RankSum().deadline_rank(1000.0)
    assert seen == [pytest.approx(seen[1] + hurry), seen[1]]


async def test_the_same_errand_again_is_done_again(scene: Scene):
    scene.robot.events[1] = lambda: scene.book.add(make_request("again", pickup="r-5305"), None)
    await scene.play(Rules.WORKING, make_request(), make_request("b", **FAX))
    assert set((await scene.states()).values()) == {"completed"}
    steps = [step.operator for step in await scene.store.steps_of("again")]
    assert steps[0].startswith("goto-pickup-loc mitchell r-5305")
    assert len(steps) == 4
    assert steps[-1] == "deliver-item r-5313 mitchell delivermail"


async def test_what_is_on_the_tray_is_not_fetched_again(scene: Scene):
    async def cancel() -> None:
        request = scene.book.find("a")
        assert request is not None
        await scene.book.end(request, RequestState.CANCELED, "not needed")

    scene.robot.events[1] = cancel
    await scene.play(Rules.WORKING, make_request())
    assert (await scene.store.facts()).tray == {("mitchell", "delivermail")}
    await scene.play(Rules.WORKING, make_request("b"))
    steps = [step.operator.split()[0] for step in await scene.store.steps_of("b")]
    assert steps == ["goto-deliver-loc", "deliver-item"]


async def test_a_wrong_arrival_is_planned_again_from_there(scene: Scene):
    wrong = [typed("n"), typed("r-5305")] * 3
    scene.robot.answers = wrong
    lines = await scene.play(Rules.WORKING, make_request())
    assert await scene.states() == {"a": "completed"}
    assert any(line.endswith("warning: desired goal was not achieved") for line in lines)
    steps = [(s.operator.split()[0], s.state) for s in await scene.store.steps_of("a")]
    assert steps[:2] == [("goto-pickup-loc", "elsewhere"), ("goto-pickup-loc", "done")]


async def test_a_search_that_grows_large_gives_way_to_a_fresh_one(
    scene: Scene, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr("rogue.episode.NODES_OF_A_SEARCH", 10)
    monkeypatch.setattr("rogue.episode.NODES_OF_A_REQUEST", 0)
    lines = await scene.play(Rules.WORKING, make_request(), make_request("b", **FAX))
    assert set((await scene.states()).values()) == {"completed"}
    assert sum("n2 (done)" in line for line in lines) > 1
    assert sum("Message from interface" in line for line in lines) == 2
    done = [step.state for step in await scene.store.steps_of("a")]
    assert done == ["done"] * 4


async def test_what_was_decided_is_recorded_for_whom_it_concerns(scene: Scene):
    late = make_request("b", posted=1001.0, **FAX)
    scene.robot.events[0] = lambda: scene.book.add(late, None)
    await scene.play(Rules.Y1996, make_request())
    decided = await scene.store.decisions("a")
    kinds = {decision.kind for decision in decided}
    assert {DecisionKind.PLANNED, DecisionKind.STEP, DecisionKind.OVERTAKEN} <= kinds
    [merged] = [d for d in await scene.store.decisions("b") if d.kind is DecisionKind.MERGED]
    assert merged.rivals == (Rival("a", 5),)


async def test_an_urgent_errand_puts_another_aside_which_then_goes_on(scene: Scene):
    urgent = {"user": "jhm", "item": "deliverfax", "pickup": "r-5301", "deliver": "r-5303"}
    seen: list[str] = []

    async def look() -> None:
        seen.extend((await scene.states()).values())

    scene.robot.events = {
        0: lambda: scene.book.add(make_request("b", **urgent, rank=11), None),
        2: look,
    }
    can = make_request(user="khaigh", item="recyclecan", pickup="r-5305", deliver="r-5315", rank=1)
    await scene.play(Rules.WORKING, can)
    assert seen == ["suspended", "underway"]
    assert await scene.states() == {"a": "completed", "b": "completed"}
    steps = [step.operator.split()[0] for step in await scene.store.steps_of("a")]
    assert steps.count("acquire-item") == 1


async def test_of_many_requests_all_are_done_though_few_take_part_at_a_time(scene: Scene):
    items = ["delivermail", "deliverfax", "returnbook", "recyclecan"]
    users = ["mitchell", "jhm", "simmons", "veloso"]
    rooms = sorted(PLACES)
    requests = [
        make_request(f"q{n}", user=user, item=item, pickup=rooms[n % 7], deliver=rooms[n % 7 + 1])
        for n, (user, item) in enumerate((u, i) for u in users for i in items)
    ]
    await scene.play(Rules.WORKING, *requests)
    assert set((await scene.states()).values()) == {"completed"}


async def test_at_level_3_the_conversation_has_the_rules_that_decided(scene: Scene):
    await scene.book.add(make_request(), None)
    await scene.episode(Rules.WORKING, level=3).run()
    lines = [line.text for line in await scene.store.lines(0, 10_000)]
    assert any("reject applied-op rule no-premature-goto to get" in line for line in lines)
