"""A robot that notes what it does, for tests of the task tree over the bus."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass, field
from typing import Any

from tca_bus import (
    Command,
    Condition,
    Demon,
    Goal,
    Module,
    MonitorContext,
    Query,
    TapNotice,
    TaskContext,
    TaskError,
    TcaException,
)


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
        self.done.append(f"approve {notice.data.get('name', notice.message)}")

    async def hear(self, heard: Hear, _: TaskContext) -> None:
        self.done.append(f"hear {heard.name}")
