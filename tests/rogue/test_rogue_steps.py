from __future__ import annotations

from pathlib import Path

import pytest
from rogue_fakes import NO_ANSWER, ScriptedRobot

from rogue.execution import Patience, StepRunner, TaskOfRobot, Urgency, acquire, as_published
from rogue.memory import Step, Store
from rogue.outcomes import Outcome, StepOutcome

URGENCY = Urgency(priority=5, deadline=4600.0)
THING = ("mitchell", "delivermail")
MAIL = "Tom Mitchell's mail delivery"


class KilledRobot(ScriptedRobot):
    """A robot whose agent dies with a task under way: the task ends, nobody hears of it."""

    def __init__(self, at: int) -> None:
        super().__init__(answers=[NO_ANSWER])
        self.at = at

    async def perform(self, task_id: str, message: TaskOfRobot, urgency: Urgency) -> Outcome:
        if len(self.ids) == self.at:
            self.ids.append(task_id)
            raise SystemExit(task_id)
        return await super().perform(task_id, message, urgency)


class Scene:
    """One store and what was told."""

    def __init__(self, store: Store) -> None:
        self.store = store
        self.told: list[str] = []

    async def tell(self, line: str, step: int, position: int) -> None:
        if await self.store.add_line(line, 0.0, step=step, position=position):
            self.told.append(line)

    async def run(self, step: Step, robot: ScriptedRobot) -> str:
        runner = StepRunner(robot, self.store, "cafe", self.tell)
        procedure = acquire("r-5303", THING, MAIL, Patience(), as_published())
        return (await runner.run(step, procedure, URGENCY)).kind


async def begin(store: Store) -> Step:
    return await store.begin_step("acquire-item", ("r-5303", "mitchell", "delivermail"), [], 0.0)


async def test_tasks_are_named_for_ever(tmp_path: Path):
    async with Store(tmp_path) as store:
        robot = ScriptedRobot()
        assert await Scene(store).run(await begin(store), robot) == "done"
        assert robot.ids == ["cafe-1.3", "cafe-1.5", "cafe-1.7"]
        assert robot.urgencies == [URGENCY] * 3


@pytest.mark.parametrize("at", range(6))
async def test_a_step_that_died_goes_on_where_it_was(tmp_path: Path, at: int):
    async with Store(tmp_path) as store:
        step = await begin(store)
        scene = Scene(store)
        first = KilledRobot(at)
        with pytest.raises(SystemExit):
            await scene.run(step, first)
        second = ScriptedRobot(answers=first.answers)
        assert await scene.run(step, second) == "done"
    # What was under way is asked for under its old id, what was done before not at all.
    assert second.ids[0] == first.ids[-1]
    assert len(set(first.ids) | set(second.ids)) == 6
    assert scene.told.count(f"Are you finished placing {MAIL} on my tray? (y/i(mpossible)): y") == 1


async def test_what_is_told_does_not_depend_on_where_it_died(tmp_path: Path):
    tales = []
    for at in range(6):
        async with Store(tmp_path / str(at)) as store:
            step = await begin(store)
            scene = Scene(store)
            first = KilledRobot(at)
            with pytest.raises(SystemExit):
                await scene.run(step, first)
            await scene.run(step, ScriptedRobot(answers=first.answers))
            tales.append(scene.told)
    assert all(tale == tales[0] for tale in tales)


async def test_an_ended_step_is_not_run_again(tmp_path: Path):
    async with Store(tmp_path) as store:
        step = await begin(store)
        await Scene(store).run(step, ScriptedRobot())
        await store.end_step(step, StepOutcome(kind="done"), 1.0)
        assert await store.open_step() is None
