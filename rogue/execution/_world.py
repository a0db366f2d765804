"""What the agent knows of the world, in memory as it stands on disk."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable

from rogue.decisions import put_off, taken_up
from rogue.execution._operators import next_room
from rogue.memory import Facts, Hold, Store
from rogue.messages import DeliveryRequest
from rogue.outcomes import StepOutcome, Thing, Trouble
from tca_bus import Module
from xavier_sim.messages import BatteryState


class KnownWorld:
    """The robot's room, its tray, and which errands are put off until when.

    ``battery`` is what was last heard of it, None while nothing was. ``on_change`` is called after
    each change that came from outside of a step.
    """

    def __init__(self, store: Store, module: Module) -> None:
        self._store = store
        self._module = module
        self._holds: dict[str, Hold] = {}
        self.facts = Facts()
        self.battery: BatteryState | None = None
        self.on_change: Callable[[], None] = _nothing

    async def load(self) -> None:
        """Read what was known when the agent last ran."""
        self.facts = await self._store.facts()
        self._holds = {hold.request: hold for hold in await self._store.holds()}

    def is_held(self, request_id: str) -> bool:
        """Whether an errand is put off and its time has not come."""
        hold = self._holds.get(request_id)
        return hold is not None and self._module.clock.now() < hold.until

    def was_put_off(self, request_id: str, room: str, trouble: Trouble) -> bool:
        """Whether an errand was put off for a trouble at a room that was not cured since."""
        hold = self._holds.get(request_id)
        return hold is not None and (hold.room, hold.trouble) == (room, trouble)

    def holds(self) -> list[Hold]:
        """What is put off now."""
        return [hold for name, hold in self._holds.items() if self.is_held(name)]

    def waits(self, request: DeliveryRequest) -> Hold | None:
        """Why an errand is not gone on with now: something ails the room where it goes next.

        One that is to go back meanwhile, or to another room, does not wait; but a robot that is
        shut in serves only the room in which it is.
        """
        room = next_room(request, self.facts.tray)
        return next((hold for hold in self.holds() if self._hinders(hold, room)), None)

    def _hinders(self, hold: Hold, room: str) -> bool:
        """Whether what an errand is put off for is in the way of whatever goes to ``room``."""
        if hold.trouble is Trouble.SHUT_IN:
            return hold.room == self.facts.room != room
        return hold.room == room

    def next_due(self, requests: Iterable[DeliveryRequest]) -> float | None:
        """When the first of these errands that wait is to be taken up again."""
        found = (hold.until for hold in map(self.waits, requests) if hold is not None)
        return min(found, default=None)

    def after_step(self, outcome: StepOutcome, holds: Iterable[Hold]) -> None:
        """Take over what a step has changed, which is on disk already."""
        self.facts = self.facts.changed(room=outcome.room, placed=outcome.placed, gone=outcome.gone)
        self._holds.update((hold.request, hold) for hold in holds)

    async def move_things(
        self, *, placed: Iterable[Thing] = (), gone: Iterable[Thing] = ()
    ) -> None:
        """Take in that somebody put things on the tray or took them from it."""
        placed, gone = set(placed) - self.facts.tray, set(gone) & self.facts.tray
        if placed or gone:
            await self._store.move_things(placed=placed, gone=gone)
            self.facts = self.facts.changed(room=self.facts.room, placed=placed, gone=gone)
            self.on_change()

    async def put_off(self, holds: Iterable[Hold]) -> None:
        """Put errands off for something that was heard."""
        new = {hold.request: hold for hold in holds}
        if new:
            self._store.record(put_off(new.values(), self._module.clock.now()))
            await self._store.put_off(new.values())
            self._holds.update(new)
            self.on_change()

    async def take_up(self, room: str, troubles: Collection[Trouble]) -> list[str]:
        """Let errands go on that were put off for such a trouble at a room; gives their ids."""
        freed = [
            name
            for name, hold in self._holds.items()
            if hold.room == room and hold.trouble in troubles
        ]
        waiting = [name for name in freed if self.is_held(name)]
        if freed:
            now = self._module.clock.now()
            self._store.record(taken_up(waiting, room, troubles, now))
            await self._store.take_up(freed)
            for name in freed:
                self._holds.pop(name, None)
            self.on_change()
        return waiting


def _nothing() -> None:
    """What is called at a change before anybody cares."""
