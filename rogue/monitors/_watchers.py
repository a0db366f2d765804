"""What is watched on the bus, and what becomes of the plans when it changes."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Iterator

from rogue import trace
from rogue.conversation import Conversation
from rogue.execution import Executor, Patience, next_room
from rogue.memory import Hold
from rogue.messages import DeliveryRequest, RequestState
from rogue.monitors._needed import Kind, subject_of
from rogue.monitors._registry import Watcher
from rogue.outcomes import Thing, Trouble
from rogue.requests import RequestBook
from tca_bus import Module, TaskState, TcaError
from xavier_sim.messages import (
    Ask,
    Battery,
    BatteryState,
    DoorMoved,
    ItemMoved,
    ReadBattery,
    WorldDoors,
)

log = logging.getLogger(__name__)


class DoorWatcher(Watcher):
    """Puts errands off whose next room was closed, and takes them up when it is open again."""

    kind = Kind.DOOR

    def __init__(
        self,
        module: Module,
        book: RequestBook,
        executor: Executor,
        conversation: Conversation,
        patience: Patience,
    ) -> None:
        super().__init__()
        self._module = module
        self._book = book
        self._world = executor.world
        self._conversation = conversation
        self._patience = patience
        self._shut: set[str] = set()
        self._reviewing = asyncio.Lock()

    async def listen(self) -> None:
        """Follow what is told of doors."""
        async with self._module.subscribe(DoorMoved) as news:
            async for moved in news:
                with self._module.clock.hold():
                    await self._moved(moved)

    async def _moved(self, moved: DoorMoved) -> None:
        if moved.open:
            await self._opened(moved.room)
        else:
            self._shut.add(moved.room)
            await self.review()

    async def look(self, subjects: frozenset[str]) -> None:
        """Ask how doors stand; where nothing can be asked, a robot finds out by driving there."""
        del subjects
        try:
            doors = await self._module.query(WorldDoors())
        except TcaError as error:
            log.info("nobody knows how the doors stand: %s", error)
            return
        self._shut = {door.room for door in doors if not door.open}
        await self.review()

    async def review(self) -> None:
        """Put off what would lead to a closed door next; once only, then the robot tries it."""
        async with self._reviewing:
            holds = list(self._at_closed_doors())
            await self._world.put_off(holds)
            await self._tell([f"{hold.request} is put off: {hold.outlook}." for hold in holds])

    def _at_closed_doors(self) -> Iterator[Hold]:
        until = self._module.clock.now() + self._patience.later
        shut, facts = self._shut - {self._world.facts.room}, self._world.facts
        for request in self._book.open_requests():
            room = next_room(request, facts.tray)
            if room in shut and not self._world.was_put_off(request.id, room, Trouble.BLOCKED):
                yield Hold(
                    request.id, room, until, f"the door of {room} is closed", Trouble.BLOCKED
                )

    async def _opened(self, room: str) -> None:
        self._shut.discard(room)
        freed = await self._world.take_up(room, {Trouble.BLOCKED, Trouble.SHUT_IN})
        await self._tell([f"The door of {room} is open again: {name} goes on." for name in freed])

    async def _tell(self, sentences: list[str]) -> None:
        await self._conversation.tell_all(map(trace.remark, sentences))


class ItemWatcher(Watcher):
    """Notices what somebody puts on the tray, takes from it, or brings by hand."""

    kind = Kind.ITEM

    def __init__(self, module: Module, book: RequestBook, executor: Executor) -> None:
        super().__init__()
        self._module = module
        self._book = book
        self._executor = executor

    async def listen(self) -> None:
        """Follow what is told of items."""
        async with self._module.subscribe(ItemMoved) as news:
            async for moved in news:
                if subject_of((moved.user, moved.item)) in self.subjects:
                    with self._module.clock.hold():
                        await self._moved(moved)

    async def _moved(self, moved: ItemMoved) -> None:
        thing, world = (moved.user, moved.item), self._executor.world
        if self._executor.is_handing_over(thing):
            # The end of that step says the same.
            return
        if moved.action == "placed":
            await world.move_things(placed=[thing])
            return
        await world.move_things(gone=[thing])
        request = self._of(thing)
        if request is None:
            return
        if moved.action == "brought":
            await self._book.end(request, RequestState.COMPLETED, "somebody else brought it")
        elif request.closing is not None:
            reason = "somebody took the item from the tray"
            await self._book.end(request, request.closing.state, reason)

    def _of(self, thing: Thing) -> DeliveryRequest | None:
        found = (r for r in self._book.open_requests() if (r.user, r.item) == thing)
        return next(found, None)


class PeopleWatcher(Watcher):
    """Notices by the answers that anybody gives that somebody is in again."""

    kind = Kind.PERSON

    def __init__(self, module: Module, executor: Executor) -> None:
        super().__init__()
        self._module = module
        self._world = executor.world

    async def listen(self) -> None:
        """Follow in the task tree what becomes of the questions that are asked."""
        async with self._module.watch_statuses(sender=self._module.name) as statuses:
            async for status in statuses:
                answered = status.name == Ask.wire_name and status.state is TaskState.ACHIEVED
                room = status.data.get("room") if answered else None
                if room in self.subjects:
                    with self._module.clock.hold():
                        await self._world.take_up(room, {Trouble.NOBODY, Trouble.UNSURE})


class BatteryWatcher(Watcher):
    """Knows how full the battery is, so that the robot charges it in time; warns when it is low."""

    kind = Kind.BATTERY

    def __init__(self, module: Module, executor: Executor, conversation: Conversation) -> None:
        super().__init__()
        self._module = module
        self._world = executor.world
        self._conversation = conversation
        self._warned = False

    async def listen(self) -> None:
        """Follow what is told of the battery."""
        async with self._module.subscribe(Battery) as news:
            async for battery in news:
                with self._module.clock.hold():
                    await self._stands(battery.state)

    async def look(self, subjects: frozenset[str]) -> None:
        """Ask how full it is; a robot without a battery needs none."""
        del subjects
        try:
            await self._stands(await self._module.query(ReadBattery()))
        except TcaError as error:
            log.info("nobody knows how full the battery is: %s", error)

    async def _stands(self, battery: BatteryState) -> None:
        self._world.battery = battery
        if battery.low and not self._warned:
            left = f"The battery is low ({battery.charge:.0%})."
            await self._conversation.tell(trace.remark(left))
        self._warned = battery.low
