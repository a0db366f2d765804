"""A robot that answers as a test tells it to."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Coroutine, Iterable
from dataclasses import dataclass, field
from typing import Self

from navigate.messages import NavigateToGoal, SetPosition
from rogue.conversation import Conversation
from rogue.errands import Travel
from rogue.execution import (
    AwaitCharge,
    Believe,
    CheckTray,
    Effect,
    Locate,
    Look,
    Perform,
    Procedure,
    TaskOfRobot,
    Tell,
    Urgency,
)
from rogue.memory import Store
from rogue.messages import DeliveryRequest, RequestState
from rogue.outcomes import Outcome, StepOutcome
from rogue.requests import Directory, FingerServer, Prospects, Questions, Reception, RequestBook
from tca_bus import Broadcast, Message, NoHandlerError, TaskState, TaskStatus
from tca_bus.testing import ManualClock
from xavier_sim.messages import Ask, Say

PLACES = {f"r-53{number:02d}": (567.0, 1777.0 + 179.83 * number) for number in range(1, 16, 2)}
PLACES |= {"r-5303": (567.0, 2316.5), "r-5313": (567.0, 4115.0)}

NO_ANSWER = Outcome(failure="no_answer", text="nobody answered within 60 s")


def typed(answer: str) -> Outcome:
    return Outcome(value={"answer": answer, "time": 0.0})


def failed(name: str, **data: object) -> Outcome:
    return Outcome(failure=name, text=f"it was {name}", value=data)


def position(room: str | None, confidence: float = 0.0) -> Outcome:
    names = ("x", "y", "theta", "deviation", "heading_deviation", "time")
    return Outcome(value={**dict.fromkeys(names, 0.0), "room": room, "confidence": confidence})


def plate(room: str | None, confidence: float = 0.95, expected: float = 0.0) -> Outcome:
    value = {"plate": room, "confidence": confidence, "expected": expected}
    return Outcome(value={**value, "position": position(room, 0.8).value})


@dataclass
class ScriptedRobot:
    """Drives succeed and people say yes, but for what the scripts hold, first come first used.

    The navigator believes in the room of its last drive unless ``belief`` says otherwise.
    """

    drives: list[Outcome] = field(default_factory=list)
    answers: list[Outcome] = field(default_factory=list)
    belief: Outcome | None = None
    arrived: str | None = None
    plates: list[Outcome] = field(default_factory=list)
    performed: list[TaskOfRobot] = field(default_factory=list)
    ids: list[str] = field(default_factory=list)
    urgencies: list[Urgency] = field(default_factory=list)
    tray: set[tuple[str, str]] = field(default_factory=set)
    running: str | None = None
    killed: list[str] = field(default_factory=list)
    charged: list[float] = field(default_factory=list)

    def outcome(self, effect: Effect) -> Outcome:
        """What comes of an effect."""
        match effect:
            case Locate(room) if room not in PLACES:
                return failed("unknown_room")
            case Locate(room):
                x, y = PLACES[room]
                return Outcome(value={"room": room, "x": x, "y": y})
            case Believe():
                return self.belief or position(self.arrived, 0.99)
            case Look():
                return self.plates.pop(0) if self.plates else failed("no_handler")
            case CheckTray(user, item):
                return Outcome(value={"on_tray": (user, item) in self.tray})
            case Perform(message):
                return self.act(message)
            case AwaitCharge(charge):
                self.charged.append(charge)
                return Outcome()
            case Tell():
                return Outcome()

    def act(self, message: TaskOfRobot) -> Outcome:
        self.performed.append(message)
        match message:
            case Say(text=text):
                return Outcome(value={"text": text, "time": 0.0})
            case Ask():
                return self.answers.pop(0) if self.answers else typed("y")
            case SetPosition(room=room) if room not in PLACES:
                return failed("unknown_room")
            case NavigateToGoal(x=x, y=y):
                drive = self.drives.pop(0) if self.drives else Outcome()
                if not drive.failed:
                    here = (r for r, place in PLACES.items() if place == (x, y))
                    self.arrived = next(here, None)
                return drive
        return Outcome()

    def count(self, kind: type[TaskOfRobot]) -> int:
        """How often a kind of task was carried out."""
        return sum(isinstance(message, kind) for message in self.performed)

    async def locate(self, effect: Locate) -> Outcome:
        return self.outcome(effect)

    async def believe(self, effect: Believe) -> Outcome:
        return self.outcome(effect)

    async def look(self, effect: Look) -> Outcome:
        return self.outcome(effect)

    async def await_charge(self, effect: AwaitCharge) -> Outcome:
        return self.outcome(effect)

    async def perform(self, task_id: str, message: TaskOfRobot, urgency: Urgency) -> Outcome:
        self.urgencies.append(urgency)
        self.ids.append(task_id)
        return self.act(message)

    async def kill(self, task_id: str, reason: str) -> None:
        del reason
        self.killed.append(task_id)


def play(
    procedure: Procedure, answer: Callable[[Effect], Outcome]
) -> tuple[StepOutcome, list[str]]:
    """Run a procedure; gives its outcome and the lines that it printed."""
    lines: list[str] = []
    effect = next(procedure)
    while True:
        if isinstance(effect, Tell):
            lines.append(effect.line)
        try:
            effect = procedure.send(answer(effect))
        except StopIteration as stop:
            return stop.value, lines


class FakeStream:
    """What a fake module hears of one kind."""

    def __init__(self) -> None:
        self._queue: asyncio.Queue[object] = asyncio.Queue()
        self._waits = False

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        pass

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> object:
        self._waits = True
        item = await self._queue.get()
        self._waits = False
        return item

    def push(self, item: object) -> None:
        self._queue.put_nowait(item)

    def is_drained(self) -> bool:
        """Whether all that was heard was worked on: the listener has come back for more."""
        return self._queue.empty() and self._waits


class FakeModule:
    """A module that is on no bus: remembers what was broadcast and served.

    ``answers`` are what others answer to its queries, by the type of the query; ``listeners``
    what it listens to, by the type of the message; `TaskStatus` stands for the task tree.
    """

    name = "rogue"
    statuses = TaskStatus

    def __init__(self, answers: dict[type, object] | None = None) -> None:
        self.clock = ManualClock(start=1000.0)
        self.said: list[Broadcast] = []
        self.handlers: dict[type, Callable[..., Awaitable[object]]] = {}
        self.answers = answers or {}
        self.listeners: dict[type, FakeStream] = {}
        self.tasks: list[asyncio.Task[object]] = []

    async def broadcast(self, message: Broadcast) -> None:
        self.said.append(message)

    def serve(self, kind: type, function: Callable[..., Awaitable[object]]) -> None:
        self.handlers[kind] = function

    def start(self, coroutine: Coroutine[object, object, object], *, name: str) -> None:
        self.tasks.append(asyncio.create_task(coroutine, name=name))

    async def query(self, message: Message) -> object:
        if type(message) in self.answers:
            return self.answers[type(message)]
        raise NoHandlerError(message.wire_name)

    def subscribe(self, kind: type) -> FakeStream:
        self.listeners[kind] = FakeStream()
        return self.listeners[kind]

    def watch_statuses(self, *, sender: str) -> FakeStream:
        del sender
        return self.subscribe(self.statuses)

    def hear(self, message: Message) -> None:
        """Have it hear a broadcast."""
        self.listeners[type(message)].push(message)

    def answered(self, room: str) -> None:
        """Have it see in the task tree that somebody answered at a room."""
        status = TaskStatus.model_construct(
            name=Ask.wire_name, state=TaskState.ACHIEVED, data={"room": room}
        )
        self.listeners[self.statuses].push(status)

    async def ask(self, message: Message) -> object:
        """What a handler of this module answers."""
        return await self.handlers[type(message)](message, None)


class HangingRobot(ScriptedRobot):
    """A robot that drives and never arrives."""

    def __init__(self) -> None:
        super().__init__()
        self.driving = asyncio.Event()

    async def perform(self, task_id: str, message: TaskOfRobot, urgency: Urgency) -> Outcome:
        self.running = task_id
        self.driving.set()
        await asyncio.get_running_loop().create_future()
        return Outcome()


def make_request(name: str = "a", **fields: object) -> DeliveryRequest:
    """The request of Figure 6, but for ``fields``."""
    values: dict[str, object] = {
        "id": name,
        "user": "mitchell",
        "item": "delivermail",
        "pickup": "r-5303",
        "deliver": "r-5313",
        "state": RequestState.QUEUED,
        "rank": 5,
        "posted": 1000.0,
        "deadline": 4600.0,
    }
    return DeliveryRequest.model_validate({**values, **fields})


def reception(
    module: FakeModule, store: Store, directory: Directory, server: FingerServer | None = None
) -> Reception:
    """The desk's help in filling in requests."""
    questions = Questions(module, store, Conversation(module, store))
    return Reception(store=store, directory=directory, questions=questions, server=server)


def prospects(module: FakeModule, store: Store, book: RequestBook) -> Prospects:
    """The desk's view of deadlines, over places in one line, with numbers for names."""

    async def learn(rooms: Iterable[str]) -> None:
        del rooms

    travel = Travel(distance=_between, speed=0.5, handling=20.0)
    return Prospects(module=module, store=store, book=book, travel=travel, learn=learn)


def _between(start: str, end: str) -> float:
    return 1.8 * abs(int(start[-2:]) - int(end[-2:]))
