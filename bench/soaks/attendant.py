"""Who looks after a robot on the bus: moves the doors, and compares belief and truth."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Sequence

from navigate.messages import StopDriving, WhereAmI
from tca_bus import Context, Module
from xavier_sim.floors import build_geometry
from xavier_sim.messages import (
    FloorPlan,
    MoveDoor,
    Sensors,
    ShowWorld,
    Standing,
    TrueLocation,
    WhereReally,
)
from xavier_sim.profile import TICK
from xavier_sim.soak import LOOK_EVERY, TIME_LIMIT, Course, DoorMove, Watch

PATIENCE = 30.0
"""Wall seconds that the attendant may need to come to a tick at which time stands."""


class Attendant:
    """Does at its very tick what a soak in one process does there, while simulated time stands.

    Ticks count from that at which it was made. It never makes time move.

    Args:
        module: of the soak.
        plan: the floor as it is; all its doors are open.
        course: whose doors are moved, and in whose tally looks are counted.
        began: where the robot was at the beginning.
        crowded: whether there are people or carts.
    """

    def __init__(
        self, module: Module, plan: FloorPlan, course: Course, began: TrueLocation, *, crowded: bool
    ) -> None:
        self._module, self._course, self._crowded = module, course, crowded
        self._first, self._start_time = began.tick, began.time
        self.open_doors = dict.fromkeys(build_geometry(plan).door_names, True)
        self.watch: Watch | None = None
        self.gave_up = False
        self._speed = 0.0
        self._next = self._after(0)
        self._acted = asyncio.Event()
        module.serve(Sensors, self._on_sensors)

    def time(self, tick: int) -> float:
        """The simulated time of a tick, seconds since the epoch."""
        return self._start_time + tick * TICK

    async def see(self) -> TrueLocation:
        """The truth about the robot now."""
        return self._since_first(await self._module.query(WhereReally()))

    async def see_all(self) -> tuple[TrueLocation, Sequence[Standing]]:
        """The same, and who and what stands about, at the same tick."""
        if not self._crowded:
            return await self.see(), ()
        world = await self._module.query(ShowWorld())
        return self._since_first(world.robot), world.standing

    async def attend(self) -> None:
        """Do what is due, tick after tick, until cancelled."""
        while True:
            async with self._module.clock.at(self.time(self._next)):
                await self._act(self._next)
                self._next = self._after(self._next)
                self._acted.set()

    async def until_acted(self, tick: int) -> None:
        """Wait until everything is done that was due up to a tick that has come.

        Raises:
            TimeoutError: it is not within `PATIENCE`.
        """
        async with asyncio.timeout(PATIENCE):
            while self._next <= tick:
                self._acted.clear()
                await self._acted.wait()

    async def move(self, moves: list[DoorMove]) -> bool:
        """Open and shut doors; true when one moved."""
        moved = False
        for door, is_open in moves:
            before = self.open_doors[door]
            if is_open != before:
                state = await self._module.query(MoveDoor(room=door, open=is_open))
                self.open_doors[door] = state.open
                moved |= state.open != before
        return moved

    async def _act(self, tick: int) -> None:
        if await self.move(self._course.doors.due(tick)):
            self._course.tally.door_moves += 1
            if self.watch is not None:
                self.watch.doors_moved((await self.see()).space, self.open_doors, tick)
        if self.watch is not None and tick % LOOK_EVERY == 0:
            await self._look(self.watch, tick)

    async def _look(self, watch: Watch, tick: int) -> None:
        seen, around = await self.see_all()
        believed = await self._module.query(WhereAmI())
        where = (believed.x, believed.y)
        watch.look((seen.x, seen.y), where, self._speed, self._course.tally, around)
        if watch.seconds(tick) >= TIME_LIMIT and not self.gave_up:
            self.gave_up = True
            await self._module.query(StopDriving())

    def _since_first(self, seen: TrueLocation) -> TrueLocation:
        return seen.model_copy(update={"tick": seen.tick - self._first})

    def _after(self, tick: int) -> int:
        """The next tick at which something is due."""
        look = (tick // LOOK_EVERY + 1) * LOOK_EVERY
        door = self._course.doors.next_tick
        return look if door > look else max(tick + 1, math.ceil(door))

    async def _on_sensors(self, sensors: Sensors, _context: Context) -> None:
        self._speed = sensors.speed
