"""The ``navigate`` module: the navigator on the bus."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from navigate.body import fault_of
from navigate.driving import STOP
from navigate.driving import Drive as Errand
from navigate.keeping import StateFile
from navigate.maps import CENTIMETRES, Point, UnknownRoomError
from navigate.messages import (
    NavigateToGoal,
    NavigationFailure,
    NavigationReport,
    PlanRoute,
    PlanRoutes,
    Position,
    RoomLocation,
    Rooms,
    Route,
    RouteTable,
    SetPosition,
    WhereAmI,
    WhereIsRoom,
)
from navigate.navigator import Navigator
from navigate.routes import NoRouteError, as_table, describe, show_point
from tca_bus import (
    BusGoneError,
    BusOptions,
    ClosedError,
    Context,
    Module,
    NoHandlerError,
    TaskContext,
    TaskError,
)
from xavier_sim.messages import DoorMoved, Drive, Sensors

NAME = "navigate"
SAVE_SECONDS = 1.0
"""Wall seconds between two savings of the state."""

SENSOR_SECONDS = 30.0
"""Wall seconds that a goal waits for a robot that says nothing yet."""

CLOCK_SECONDS = 2.0
"""Wall seconds that the end of a drive waits for the time of its last tick to be told."""

log = logging.getLogger(__name__)


@contextmanager
def _told_unknown() -> Iterator[None]:
    """Fail with a name that callers can tell when the map has no such room."""
    try:
        yield
    except UnknownRoomError as error:
        raise TaskError("unknown_room", str(error), data={"near": error.near}) from error


class NavigateService:
    """Serves a `Navigator` on the bus, with its state in ``kept`` if that is given.

    Use: ``await NavigateService(navigator, options).run()``; it runs until cancelled.
    """

    def __init__(
        self, navigator: Navigator, options: BusOptions | None, kept: StateFile | None = None
    ) -> None:
        self.module = Module(NAME, options=options, sole=True)
        self._navigator, self._kept = navigator, kept
        self._sensors: Sensors | None = None
        self._heard, self._ended = asyncio.Event(), asyncio.Event()
        self._errand: Errand | None = None
        self._unheard, self._faults = 0, 0
        self._measuring = asyncio.Lock()
        self.module.serve(Sensors, self._on_sensors)
        self.module.serve(DoorMoved, self._on_door_moved)
        self.module.serve(NavigateToGoal, self._on_goal)
        self.module.serve(SetPosition, self._on_set_position)
        self.module.serve(WhereAmI, self._on_where)
        self.module.serve(WhereIsRoom, self._on_room)
        self.module.serve(Rooms, self._on_rooms)
        self.module.serve(PlanRoute, self._on_plan)
        self.module.serve(PlanRoutes, self._on_plan_many)

    async def run(self) -> None:
        """Serve until cancelled.

        Raises:
            BusGoneError: there is no router.
            RefusedError: there is a navigator on the realm.
        """
        self._load()
        async with self.module:
            if self._kept is not None:
                self.module.start(self._keep(self._kept), name="navigate keeps its state")
            await self.module.serve_forever()

    async def _on_sensors(self, sensors: Sensors, _context: Context) -> None:
        if fault := fault_of(sensors):
            await self._refuse(sensors, fault)
            return
        self._faults = 0
        last, self._sensors = self._sensors, sensors
        if last is None or (sensors.tick, sensors.time) != (last.tick, last.time):
            self._navigator.step(sensors)
            self._heard.set()
            if self._errand is not None and self._errand.done:
                self._ended.set()
        await self._answer(sensors)

    async def _on_door_moved(self, moved: DoorMoved, _context: Context) -> None:
        if moved.open:
            self._navigator.hear_opened(moved.room)

    async def _refuse(self, sensors: Sensors, fault: str) -> None:
        """Stand still on readings that are useless, and say so once."""
        self._faults += 1
        if self._faults == 1:
            log.warning("sensors of tick %d are of no use: %s", sensors.tick, fault)
        self._navigator.wheels = STOP
        await self._answer(sensors)

    async def _answer(self, sensors: Sensors) -> None:
        """Answer the sensors of a tick; a robot that went away is no reason to end."""
        wheels, busy = self._navigator.wheels, self._navigator.busy
        drive = Drive(tick=sensors.tick, speed=wheels.speed, turn_rate=wheels.turn, busy=busy)
        try:
            await self.module.inform(drive)
        except ClosedError:
            # This module is on its way out, and the robot sees that it goes.
            return
        except (NoHandlerError, BusGoneError) as error:
            self._unheard += 1
            if self._unheard == 1:
                log.warning("nobody takes the wheels' commands: %s", error)
        else:
            self._unheard = 0

    async def _on_goal(self, goal: NavigateToGoal, _context: TaskContext) -> NavigationReport:
        sensors = await self._first_sensors()
        point = (goal.x / CENTIMETRES, goal.y / CENTIMETRES)
        self._ended.clear()
        self._errand = errand = self._navigator.start(point, sensors)
        log.info("drives to %s", self._name(point))
        try:
            if not errand.done:
                await self._answer(sensors)
                await self._ended.wait()
        finally:
            self._errand = None
            await self._stop()
        await self._until_told()
        return self._ending(errand, point)

    async def _until_told(self) -> None:
        """Let all hear the time of the last tick before they hear what came of it.

        In lockstep time stands still once the drive has ended; who reads the clock on hearing of
        it should find the same time in every run.
        """
        sensors = self._sensors
        if sensors is None or not sensors.lockstep:
            return
        try:
            async with asyncio.timeout(CLOCK_SECONDS):
                await self.module.clock.watch_until(sensors.time)
        except TimeoutError:
            log.warning("nobody tells the time of tick %d", sensors.tick)

    async def _first_sensors(self) -> Sensors:
        try:
            async with asyncio.timeout(SENSOR_SECONDS):
                await self._heard.wait()
        except TimeoutError as error:
            text = f"the robot has sent no sensor readings for {SENSOR_SECONDS:.0f} s"
            raise TaskError(NavigationFailure.LOST, text) from error
        assert self._sensors is not None
        return self._sensors

    async def _stop(self) -> None:
        """Stand, and say so to the robot: also when the drive was cancelled under way."""
        self._navigator.cancel()
        if self._sensors is not None:
            await self._answer(self._sensors)

    def _ending(self, errand: Errand, point: Point) -> NavigationReport:
        report = self._navigator.report(errand)
        if errand.failure is None:
            log.info("arrived at %s, %.1f m", self._name(point), report.metres)
            return report
        text = f"did not get to {self._name(point)}: {errand.failure.text}"
        log.warning("%s (%s)", text, errand.failure.reason)
        raise TaskError(errand.failure.reason, text, data=report) from errand.failure

    def _name(self, point: Point) -> str:
        room = self._navigator.floor.room_near(*point)
        return room or show_point(point)

    async def _on_set_position(self, command: SetPosition, _context: TaskContext) -> Position:
        with _told_unknown():
            return self._navigator.set_position(command.room)

    async def _on_where(self, _query: WhereAmI, _context: Context) -> Position:
        return self._navigator.position()

    async def _on_room(self, query: WhereIsRoom, _context: Context) -> RoomLocation:
        with _told_unknown():
            return self._navigator.floor.location(query.room)

    async def _on_rooms(self, _query: Rooms, _context: Context) -> list[RoomLocation]:
        floor = self._navigator.floor
        return [floor.location(room) for room in floor.places]

    async def _on_plan(self, query: PlanRoute, _context: Context) -> Route:
        navigator = self._navigator
        floor, here = navigator.floor, navigator.localizer.estimate
        with _told_unknown():
            start = floor.place(query.start) if query.start else (here.x, here.y)
            goal = floor.place(query.goal)
        hindrances = navigator.memory.believed(navigator.time)
        try:
            steps = navigator.planner.plan(start, goal, hindrances)
        except NoRouteError as error:
            raise TaskError(NavigationFailure.NO_ROUTE, str(error)) from error
        return describe(start, steps)

    async def _on_plan_many(self, query: PlanRoutes, _context: Context) -> RouteTable:
        navigator = self._navigator
        here = navigator.localizer.estimate
        with _told_unknown():
            places = [navigator.floor.place(room) for room in query.rooms]
        hindrances = navigator.memory.believed(navigator.time)
        starts = [*places, (here.x, here.y)]
        # In a thread: the wheels go on being answered meanwhile.
        async with self._measuring:
            find = navigator.distances.between
            found = await asyncio.to_thread(find, starts, places, hindrances)
        return as_table(query.rooms, found)

    def _load(self) -> None:
        state = self._kept.load() if self._kept else None
        if state is None:
            return
        if state.get("map") != self._navigator.floor.plan.name:
            log.warning("the state that was kept is of map %s; not used", state.get("map"))
            return
        try:
            self._navigator.restore(state)
        except (KeyError, TypeError, ValueError) as error:
            log.warning("the state that was kept cannot be used: %r", error)

    async def _keep(self, kept: StateFile) -> None:
        """Save about once a second what has changed."""
        saved: dict[str, Any] = {}
        while True:
            await asyncio.sleep(SAVE_SECONDS)
            state = self._navigator.snapshot()
            if state == saved or self._sensors is None:
                continue
            try:
                await asyncio.to_thread(kept.save, state)
                saved = state
            except OSError as error:
                log.warning("%s cannot be written: %s", kept.path, error.strerror)
