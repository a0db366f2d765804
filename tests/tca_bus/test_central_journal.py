"""The journal: what it keeps, what it gives back, and what it refuses to open."""

from __future__ import annotations

import math
import sqlite3

import pytest

from tca_bus import ConfigError, Failure, TaskStatus
from tca_bus._journal import Journal, JournalError, migrations
from tca_bus._protocol import Outcome, ReadLog, SubmitTask
from tca_bus.tasktree import (
    Ended,
    Event,
    Freed,
    KillRequested,
    ProviderAppeared,
    Record,
    Reported,
    Submitted,
    Tree,
)


class Keeper:
    """A tree whose effects go into a journal, as central has them."""

    def __init__(self, journal: Journal) -> None:
        self.journal = journal
        self.tree = Tree()
        self.tree.apply(ProviderAppeared(0.0, "robot", "r1", {"drive": 100}))

    async def happen(self, *events: Event) -> None:
        effects = [effect for event in events for effect in self.tree.apply(event)]
        await self.journal.write(
            [effect for effect in effects if isinstance(effect, Record)],
            [effect for effect in effects if isinstance(effect, Freed)],
            [effect for effect in effects if isinstance(effect, Ended)],
        )

    async def submit(self, id: str, parent: str | None = None, time: float = 1.0) -> None:
        task = SubmitTask(
            id=id,
            name="drive",
            task_class="command",
            data={"to": "r-5303"},
            sender="me",
            parent=parent,
            constraints=0,
        )
        await self.happen(Submitted(time, task))

    async def end(self, id: str, time: float = 2.0) -> None:
        await self.happen(Reported(time, id, 1, Outcome.SUCCESS, result={"x": 1}))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "data" / "central.db"


async def test_it_gives_back_the_tree_that_was_written(path):
    async with Journal(path) as journal:
        keeper = Keeper(journal)
        await keeper.submit("a")
        await keeper.submit("b", "a")
        await keeper.submit("c")
        await keeper.end("c")
    async with Journal(path) as journal:
        assert journal.generation == 2
        tree = Tree()
        tree.replay(await journal.living_events())
    assert [status.id for status in tree.statuses()] == ["a", "b"]
    assert tree.statuses() == keeper.tree.statuses()


async def test_infinite_numbers_are_kept(path):
    task = SubmitTask(
        id="a", name="drive", task_class="command", data={"to": math.inf}, sender="me"
    )
    async with Journal(path) as journal:
        keeper = Keeper(journal)
        await keeper.happen(Submitted(1.0, task))
        submitted = (await journal.living_events())[0]
        assert submitted.task == task
        await keeper.happen(Reported(2.0, "a", 1, Outcome.SUCCESS, -math.inf))
        ended = await journal.find("a")
        assert (ended.data, ended.result) == ({"to": math.inf}, -math.inf)


async def test_ended_tasks_are_found_with_all_below_them(path):
    async with Journal(path) as journal:
        keeper = Keeper(journal)
        await keeper.submit("a")
        await keeper.submit("b", "a")
        await keeper.end("b")
        await keeper.end("a")
    async with Journal(path) as journal:
        status = await journal.find("b")
        assert isinstance(status, TaskStatus)
        assert status.result == {"x": 1}
        assert [status.id for status in await journal.ended_tree("b")] == ["a", "b"]
        assert [status.id for status in await journal.last_ended(1)] == ["a", "b"]
        assert await journal.find("c") is None
        assert await journal.ended_tree("c") == []


async def test_the_log_is_read_forwards_backwards_and_by_task(path):
    async with Journal(path) as journal:
        keeper = Keeper(journal)
        await keeper.submit("a")
        await keeper.submit("b")
        failure = Failure(name="door_blocked", text="the door is closed")
        await keeper.happen(Reported(2.0, "a", 1, Outcome.FAILURE, failure=failure))
        await keeper.happen(KillRequested(3.0, "b", "enough"))
        log = await journal.read_log(ReadLog(after=0, most=100))
        assert [(line.task, line.event) for line in log] == [
            ("a", "submitted"),
            ("a", "dispatched"),
            ("b", "submitted"),
            ("b", "dispatched"),
            ("a", "handler failed"),
            ("a", "uncaught"),
            ("a", "failed"),
            ("b", "kill requested"),
        ]
        assert "the door is closed (door_blocked)" in log[6].text
        assert await numbers(journal, after=-2) == [7, 8]
        assert await numbers(journal, most=3) == [1, 2, 3]
        assert await numbers(journal, after=4, task="a") == [5, 6, 7]
        assert await numbers(journal, messages=("quick",)) == []
        assert await numbers(journal, after=-1, messages=("drive",)) == [8]
        assert await numbers(journal, ignore=("drive",)) == []


async def numbers(journal, **question):
    return [line.number for line in await journal.read_log(ReadLog(**question))]


async def test_a_forgotten_kill_ends_and_its_task_may_still_come(path):
    async with Journal(path) as journal:
        keeper = Keeper(journal)
        await keeper.happen(KillRequested(1.0, "late", "no"))
        assert len(await journal.living_events()) == 1
    async with Journal(path) as journal:
        assert await journal.living_events() == []
        keeper = Keeper(journal)
        await keeper.submit("late", time=100.0)
        assert len(await journal.living_events()) == 3


async def test_one_journal_has_one_central(path):
    async with Journal(path):
        with pytest.raises(ConfigError, match="no other central uses"):
            async with Journal(path):
                pass


async def test_a_damaged_file_is_named(path):
    path.parent.mkdir()
    path.write_bytes(b"no database " * 1000)
    with pytest.raises(ConfigError, match=r"central\.db.*an intact journal"):
        async with Journal(path):
            pass


async def test_a_database_of_another_program_is_left_alone(path):
    path.parent.mkdir()
    with sqlite3.connect(path) as other:
        other.execute("CREATE TABLE recipes (name TEXT)")
    other.close()
    with pytest.raises(ConfigError, match="a journal of central"):
        async with Journal(path):
            pass


async def test_a_journal_of_a_later_version_is_refused(path):
    async with Journal(path):
        pass
    with sqlite3.connect(path) as later:
        later.execute("PRAGMA user_version = 99")
    later.close()
    with pytest.raises(ConfigError, match=f"version {len(migrations())} or earlier, not 99"):
        async with Journal(path):
            pass


async def test_a_line_that_cannot_be_read_is_named(path):
    async with Journal(path) as journal:
        await Keeper(journal).submit("a")
    with sqlite3.connect(path) as vandal:
        vandal.execute("UPDATE events SET body = '{' WHERE number = 2")
    vandal.close()
    async with Journal(path) as journal:
        with pytest.raises(JournalError, match="line 2"):
            await journal.living_events()


async def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "data").write_text("a file")
    with pytest.raises(ConfigError, match="--data"):
        async with Journal(tmp_path / "data" / "central.db"):
            pass


async def test_without_a_file_old_history_is_forgotten(monkeypatch):
    monkeypatch.setattr("tca_bus._journal.MOST_IN_MEMORY", 40)
    async with Journal(None) as journal:
        keeper = Keeper(journal)
        await keeper.submit("alive")
        for number in range(100):
            await keeper.submit(f"n{number}")
            await keeper.end(f"n{number}")
        log = await journal.read_log(ReadLog(after=0, most=1000))
        assert len(log) < 60
        assert len(await journal.living_events()) == 2
        assert await journal.find("n0") is None
        assert await journal.find("n99") is not None
