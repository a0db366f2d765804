"""An office in one process that can be put back to any moment of a run, as a kill leaves it.

What a kill -9 of the agent leaves is the file that it had written, and the world: robot, people
and central, in which tasks go on. A `Moment` is both, taken after each commit and after each
thing that happens in the world. An agent that is started on one is an agent that was killed then.
"""

from __future__ import annotations

import asyncio
import copy
import sqlite3
from collections import Counter
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from rogue_fakes import PLACES, FakeModule, failed, plate, position, typed

from navigate.messages import NavigateToGoal, NoticeLandmark, SetPosition
from rogue.agent import Agent, AgentOptions
from rogue.execution import Believe, Locate, Look, Patience, TaskOfRobot, Urgency
from rogue.memory import Database, Store
from rogue.messages import (
    CancelRequest,
    DeliveryRequest,
    PostRequest,
    RequestChanged,
    RequestState,
)
from rogue.outcomes import Outcome
from rogue.planning import Rules
from rogue.requests import load_directory
from tca_bus import Broadcast, Message
from tca_bus.testing import ManualClock
from xavier_sim.messages import Ask, Say

Thing = tuple[str, str]

DIRECTORY = load_directory()

QUICK = Patience(asks=2, tries=2, returns=1)
"""Everything is tried again, but once: more moments would differ only in their number."""

MATTERS = ("requests", "facts", "steps", "outcomes", "holds")
"""Tables by which one moment differs from another; after a line that was told it is the same."""

NAMES = {place: room for room, place in PLACES.items()}


@dataclass(frozen=True)
class Order:
    """What a user asks of the agent, once the robot has begun so many drives."""

    after_drives: int
    message: Message


@dataclass(frozen=True)
class Play:
    """A scenario: rules, what users ask, and how the world answers.

    ``misses`` gives the room where the robot really ends up when it drives to a room for the
    n-th time, counted from 0; ``blocked`` are drives that fail, ``shut_in`` those that do so at the
    door of the room where the robot is. ``silent`` and ``refused`` are
    questions that nobody answers, and that are answered by "impossible": what about, in which
    room, asked there for the n-th time. ``places`` is how many items the tray holds.
    """

    orders: tuple[Order, ...]
    rules: Rules = Rules.WORKING
    misses: dict[tuple[str, int], str] = field(default_factory=dict)
    blocked: frozenset[tuple[str, int]] = frozenset()
    shut_in: frozenset[tuple[str, int]] = frozenset()
    silent: frozenset[tuple[str, str, int]] = frozenset()
    refused: frozenset[tuple[str, str, int]] = frozenset()
    places: int = 6


@dataclass
class World:
    """Robot, people and central: what happens once happens under one id, whoever asks again."""

    play: Play
    now: float = 1000.0
    room: str | None = None
    believed: str | None = None
    tray: set[Thing] = field(default_factory=set)
    done: dict[str, Outcome] = field(default_factory=dict)
    acts: list[str] = field(default_factory=list)
    drives: int = 0
    times: Counter[tuple[str, ...]] = field(default_factory=Counter)
    ordered: int = 0
    killed: set[str] = field(default_factory=set)

    def perform(self, task_id: str, message: TaskOfRobot) -> Outcome:
        """Carry out a task; one that has ended has its outcome."""
        if task_id not in self.done:
            self.done[task_id] = self._act(message)
        return self.done[task_id]

    def _act(self, message: TaskOfRobot) -> Outcome:
        match message:
            case NavigateToGoal(x=x, y=y):
                return self._drive(NAMES[x, y])
            case SetPosition(room=room):
                self.acts.append(f"told {room}")
                self.believed = room
                return Outcome()
            case NoticeLandmark(room=room):
                self.acts.append(f"noticed {room}")
                return Outcome()
            case Say(text=text):
                self.acts.append(f"said {text}")
                return Outcome(value={"text": text, "time": self.now})
            case Ask():
                return self._answer(message)

    def _drive(self, goal: str) -> Outcome:
        self.drives += 1
        this_time = (goal, self._count(goal))
        self.acts.append(f"drove to {goal}")
        if this_time in self.play.blocked:
            return failed("door_blocked")
        if this_time in self.play.shut_in:
            return failed("door_blocked", door=self.room)
        self.now += 30.0
        self.believed, self.room = goal, self.play.misses.get(this_time, goal)
        return Outcome()

    def _count(self, *what: str) -> int:
        """How often this has happened before."""
        self.times[what] += 1
        return self.times[what] - 1

    def _answer(self, question: Ask) -> Outcome:
        room = question.room or ""
        this_time = (question.about, room, self._count(question.about, room))
        self.acts.append(f"asked {question.question}")
        if this_time in self.play.silent:
            self.now += question.timeout
            return Outcome(failure="no_answer", text="nobody answered")
        self.now += 5.0
        if question.about == "where":
            return typed(self.room or "nowhere")
        if question.about == "place":
            return typed("y" if question.room == self.room else "n")
        thing = (question.user or "", question.item or "")
        if this_time in self.play.refused or question.room != self.room:
            return typed("i")
        if question.about == "placing":
            self.tray.add(thing)
        elif thing not in self.tray:
            return typed("i")
        else:
            self.tray.remove(thing)
        return typed("y")


class JumpingClock(ManualClock):
    """A clock that is where somebody actively waits for it to be."""

    def __init__(self, world: World) -> None:
        super().__init__(start=world.now)
        self._world = world

    def now(self) -> float:
        if self._world.now > self._time:
            self.move_to(self._world.now)
        return super().now()

    async def sleep_until(self, when: float) -> None:
        self._world.now = max(self._world.now, when)
        self.now()
        await asyncio.sleep(0)


class CrashModule(FakeModule):
    """The agent's module; tells when a request has changed."""

    def __init__(self, world: World) -> None:
        super().__init__()
        self.clock = JumpingClock(world)
        self.news = asyncio.Event()

    async def broadcast(self, message: Broadcast) -> None:
        if isinstance(message, RequestChanged):
            self.news.set()


class WorldRobot:
    """The robot of a `World`, with what users ask on the way."""

    def __init__(self, world: World, happened: Callable[[], None]) -> None:
        self.world, self._happened = world, happened
        self.orders: Callable[[], object] = list

    async def rooms(self, *, patience: float | None = None) -> dict[str, tuple[float, float]]:
        del patience
        return {room: (x / 100, y / 100) for room, (x, y) in PLACES.items()}

    async def locate(self, effect: Locate) -> Outcome:
        if effect.room not in PLACES:
            return failed("unknown_room")
        x, y = PLACES[effect.room]
        return Outcome(value={"room": effect.room, "x": x, "y": y})

    async def believe(self, effect: Believe) -> Outcome:
        del effect
        return position(self.world.believed, 0.9)

    async def look(self, effect: Look) -> Outcome:
        del effect
        return plate(self.world.room)

    async def perform(self, task_id: str, message: TaskOfRobot, urgency: Urgency) -> Outcome:
        del urgency
        known = task_id in self.world.done
        if isinstance(message, NavigateToGoal) and not known:
            self.world.drives += 1
            await self.orders()
            self.world.drives -= 1
        outcome = self.world.perform(task_id, message)
        if not known:
            self._happened()
        return outcome

    async def kill(self, task_id: str, reason: str) -> None:
        del reason
        self.world.killed.add(task_id)


@dataclass(frozen=True)
class Moment:
    """What is there when the agent is killed."""

    file: bytes
    world: World


@dataclass(frozen=True)
class Ending:
    """How it all came out."""

    requests: dict[str, tuple[RequestState, str | None]]
    tray: set[Thing]
    acts: Counter[str]
    drives: tuple[str, ...]


class MemoryConnection:
    """A database in memory with the methods of aiosqlite's that the store uses, on this thread."""

    def __init__(self, link: sqlite3.Connection) -> None:
        self._link = link

    async def execute(self, sql: str, values: Iterable[object] = ()) -> sqlite3.Cursor:
        return self._link.execute(sql, tuple(values))

    async def executemany(self, sql: str, rows: Iterable[Iterable[object]]) -> sqlite3.Cursor:
        return self._link.executemany(sql, list(rows))

    async def execute_fetchall(self, sql: str, values: Iterable[object] = ()) -> list[object]:
        return self._link.execute(sql, tuple(values)).fetchall()

    async def executescript(self, script: str) -> None:
        self._link.executescript(script)

    async def commit(self) -> None:
        self._link.commit()

    async def rollback(self) -> None:
        self._link.rollback()

    async def close(self) -> None:
        pass


class Run:
    """One run of the agent, from a moment on or from the beginning."""

    def __init__(self, play: Play, *, begins: Moment | None = None) -> None:
        self.play = play
        self.moments: list[Moment] = []
        self.world = copy.deepcopy(begins.world) if begins else World(play)
        self._link = sqlite3.connect(":memory:", isolation_level=None)
        if begins is not None:
            self._link.deserialize(begins.file)
        self._keeps = begins is None
        self._last = ""

    def happened(self) -> None:
        """Keep the moment."""
        if not self._keeps:
            return
        rows = [self._link.execute(f"SELECT * FROM {table}").fetchall() for table in MATTERS]
        matters = repr((rows, self.world.acts, self.world.ordered))
        if self._last != matters:
            self._last = matters
            self.moments.append(Moment(self._link.serialize(), copy.deepcopy(self.world)))

    async def to_the_end(self, monkeypatch: pytest.MonkeyPatch) -> Ending:
        """Run until every request that was ever ordered has ended."""
        robot = WorldRobot(self.world, self.happened)
        module = CrashModule(self.world)
        monkeypatch.setattr("rogue.agent.BusRobot", lambda module, endurance: robot)
        monkeypatch.setattr("rogue.memory._database.aiosqlite.connect", self._connect)
        monkeypatch.setattr(Database, "transaction", _told_of(self.happened))
        options = AgentOptions(
            folder=Path(), rules=self.play.rules, places=self.play.places, patience=QUICK
        )
        try:
            async with Store(options.folder) as store:
                agent = Agent(module, store, DIRECTORY, options)
                await agent.load()
                agent.open_desk()
                robot.orders = lambda: self._order(module)
                module.start(agent.run(), name="agent")
                await self._order(module)
                await self._all_ended(module, store)
                return await self._ending(store)
        finally:
            for task in module.tasks:
                task.cancel()
            await asyncio.gather(*module.tasks, return_exceptions=True)
            self._link.close()

    async def _connect(self, path: Path, *, isolation_level: str | None) -> MemoryConnection:
        del path, isolation_level
        return MemoryConnection(self._link)

    async def _order(self, module: CrashModule) -> None:
        """Ask what is due; what was not acknowledged before a crash is asked again."""
        while self.world.ordered < len(self.play.orders):
            order = self.play.orders[self.world.ordered]
            if order.after_drives > self.world.drives:
                return
            await module.ask(order.message)
            self.world.ordered += 1

    async def _all_ended(self, module: CrashModule, store: Store) -> None:
        async with asyncio.timeout(60.0):
            while True:
                module.news.clear()
                due = self.world.ordered < len(self.play.orders)
                if not due and not await store.requests(open_only=True):
                    return
                with suppress(TimeoutError):
                    async with asyncio.timeout(0.5):
                        await module.news.wait()
                for task in module.tasks:
                    if task.done():
                        task.result()

    async def _ending(self, store: Store) -> Ending:
        found: list[DeliveryRequest] = await store.requests()
        return Ending(
            {request.id: (request.state, request.reason) for request in found},
            self.world.tray,
            Counter(self.world.acts),
            tuple(act for act in self.world.acts if act.startswith("drove")),
        )


def _told_of(happened: Callable[[], None]) -> Callable[[Database], object]:
    """The transactions of a database, with something done after each that was committed."""
    original = Database.transaction

    @asynccontextmanager
    async def transaction(self: Database) -> AsyncIterator[object]:
        async with original(self) as link:
            yield link
        happened()

    return transaction


def post(name: str, user: str, item: str, *, after: int = 0, **rooms: str) -> Order:
    """A user posts a request."""
    return Order(
        after, PostRequest.model_validate({"id": name, "user": user, "item": item} | rooms)
    )


def cancel(name: str, *, after: int) -> Order:
    """A user takes a request back; what is on the tray goes back."""
    return Order(after, CancelRequest(id=name, reason="not needed"))
