"""A day as it is played in a whole office, with the planner killed now and then."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
import os
import random
import signal
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from functools import partial
from typing import TypeVar

from rogue.absence import persist
from rogue.messages import (
    CancelRequest,
    ListRequests,
    PostRequest,
    RequestChanged,
    ShowRequest,
)
from rogue.scenarios._day_plan import DayEvent, DayPlan, DoorMove, Post, TakeBack
from rogue.scenarios._day_verdict import DayRecord, Handover, Verified
from rogue.scenarios._stage import Stage
from tca_bus import HandlerFailedError, Subscription, TimedOutError
from xavier_sim.messages import ItemMoved, MoveDoor, MovePerson, WhereReally

log = logging.getLogger(__name__)

T = TypeVar("T")

PLANNER = "rogue"

STUCK = 240.0
"""Wall seconds for which time stands still before the day is given up."""

LOOK_AGAIN = 2.0
"""Wall seconds after which open requests are looked at again: a broadcast may be missed."""

SECOND_THOUGHTS = 1.0
"""Seconds after which a user takes back a request whose item he has put on the tray."""

Progress = Callable[[str], None]


class DayStuckError(TimedOutError):
    """Nothing happens any more, and requests are still open."""


class DayRun:
    """Plays a script in an office and notes what is seen.

    Time moves by what the robot does; between errands, when nobody does anything, by the waiting
    for the next event.
    """

    def __init__(self, stage: Stage, plan: DayPlan, *, kills: int, progress: Progress) -> None:
        self._module, self._launcher = stage.module, stage.launcher
        self._plan = plan
        self._progress = progress
        self._kills = _moments(plan, kills)
        self._moved = -math.inf, 0.0
        self.record = DayRecord()

    async def play(self) -> DayRecord:
        """Play the script to its end, and until every request has ended.

        Raises:
            DayStuckError: it does not come to an end.
            TcaError: the office fell apart.
        """
        clock = self._module.clock
        await clock.wait_ready(STUCK)
        truth = await self._module.query(WhereReally())
        self.record.begun = truth.time
        async with (
            self._module.subscribe(ItemMoved) as moved,
            self._module.subscribe(RequestChanged) as changes,
            asyncio.TaskGroup() as group,
        ):
            watching = group.create_task(self._watch_items(moved), name="day.items")
            await self._set_scene()
            for at, event in self._events():
                async with self._at(self.record.begun + at, changes):
                    await self._do(event)
            while await self._open_requests():
                await _news(changes)
            watching.cancel()
        await self._conclude(truth.metres)
        return self.record

    def _events(self) -> Sequence[tuple[float, DayEvent | None]]:
        kills: list[tuple[float, DayEvent | None]] = [(at, None) for at in self._kills]
        return sorted([*kills, *self._plan.events()], key=lambda pair: pair[0])

    async def _set_scene(self) -> None:
        for room in sorted(self._plan.silent):
            await self._module.query(MovePerson(room=room, present=False))

    @contextlib.asynccontextmanager
    async def _at(self, when: float, changes: Subscription[RequestChanged]) -> AsyncIterator[None]:
        """Wait for a time, and do the block at exactly that time.

        While a request is open the wait is passive: the robot's work makes time move.
        """
        clock = self._module.clock
        async with contextlib.AsyncExitStack() as still:
            entering = still.enter_async_context(clock.at(when))
            coming = asyncio.create_task(entering, name="day.coming")
            try:
                while not coming.done() and await self._open_requests():
                    await self._first(coming, changes)
                if not coming.done():
                    await clock.sleep_until(when)
                await coming
            finally:
                coming.cancel()
            yield

    async def _first(
        self, coming: asyncio.Task[None], changes: Subscription[RequestChanged]
    ) -> None:
        """Wait for a time, or until a request has ended."""
        news = asyncio.create_task(_news(changes), name="day.news")
        try:
            await asyncio.wait({coming, news}, return_when=asyncio.FIRST_COMPLETED)
        finally:
            news.cancel()
            await asyncio.gather(news, return_exceptions=True)

    async def _open_requests(self) -> int:
        self._check_time()
        found = await self._ask(lambda: self._module.query(ListRequests(open_only=True)))
        return len(found)

    def _check_time(self) -> None:
        now, wall = self._module.clock.now(), time.monotonic()
        if now != self._moved[0]:
            self._moved = now, wall
        elif wall - self._moved[1] > STUCK:
            raise DayStuckError("the end of the day", STUCK)

    async def _do(self, event: DayEvent | None) -> None:
        match event:
            case None:
                await self._kill()
            case Post():
                await self._post(event)
            case TakeBack():
                await self._take_back(event)
            case DoorMove():
                await self._module.query(MoveDoor(room=event.room, open=event.open))

    async def _post(self, post: Post) -> None:
        message = PostRequest(
            id=post.id,
            user=post.user,
            item=post.item,
            pickup=post.pickup,
            deliver=post.deliver,
            deadline=f"+{post.deadline:.0f}s",
        )
        try:
            await self._ask(lambda: self._module.query(message))
        except HandlerFailedError as error:
            self.record.refused[post.id] = (error.failure.name, error.failure.text)
            self._progress(f"{post.id} refused: {error.failure.text}")
        else:
            self._progress(f"{post.id} posted: {post.item} for {post.user}")

    async def _take_back(self, change: TakeBack) -> None:
        if change.id in self.record.refused:
            return
        order = CancelRequest(id=change.id, item=change.item)
        await self._ask(lambda: self._module.query(order))
        self._progress(f"{change.id} taken back, {change.item}")

    async def _ask(self, call: Callable[[], Awaitable[T]]) -> T:
        """Ask the planner, which may just have been killed, and be away in whatever way."""
        return await persist(call, was_there=True)

    async def _kill(self) -> None:
        pid = self._launcher.pid(PLANNER)
        if pid is None:
            return
        before = self._launcher.restarts(PLANNER)
        os.kill(pid, signal.SIGKILL)
        self.record.kills += 1
        self._progress("the planner is killed")
        await self._launcher.wait_restarted(PLANNER, beyond=before)

    async def _watch_items(self, moved: Subscription[ItemMoved]) -> None:
        async for one in moved:
            at = round(one.time - self.record.begun, 1)
            self.record.handovers.append(Handover(at, one.action, one.user, one.item, one.room))
            change = self._plan.taken_from_tray(one.user, one.item)
            if one.action == "placed" and change is not None:
                # Not at this very time, at which the agent too hears of the item.
                async with self._module.clock.at(one.time + SECOND_THOUGHTS):
                    await self._take_back(change)

    async def _conclude(self, metres: float) -> None:
        truth = await self._module.query(WhereReally())
        self.record.seconds = truth.time - self.record.begun
        self.record.metres = truth.metres - metres
        for one in await self._ask(lambda: self._module.query(ListRequests())):
            self.record.ended[one.id] = one
        self.record.arrivals = await self._arrivals()

    async def _arrivals(self) -> list[Verified]:
        """What was found at the end of each drive; one that served several counts once."""
        drives: dict[tuple[float, str], list[Verified]] = {}
        for name in self.record.ended:
            details = await self._ask(partial(self._module.query, ShowRequest(id=name)))
            for step in details.steps:
                goal = step.operator.split()[-1]
                found = [Verified(goal, one.room, one.by) for one in step.arrivals]
                drives[step.started, step.operator] = found
        return [one for drive in drives.values() for one in drive]


async def _news(changes: Subscription[RequestChanged]) -> None:
    """Wait until a request has ended, or for a while."""
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(LOOK_AGAIN):
            async for change in changes:
                if change.request.state.is_final:
                    return


def _moments(plan: DayPlan, kills: int) -> list[float]:
    """When the planner is killed: seconds from the start, while there is something to do."""
    rng = random.Random(f"kills {plan.seed}")
    first, last = plan.posts[0].at, plan.posts[-1].at
    return sorted(round(rng.uniform(first, last), 1) for _ in range(kills))
