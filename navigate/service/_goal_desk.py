"""Goals on the bus: driving to them, and stopping on the way."""

from __future__ import annotations

import asyncio
import logging

from navigate.driving import Drive
from navigate.maps import CENTIMETRES, Point
from navigate.messages import (
    NavigateToGoal,
    NavigationFailure,
    NavigationReport,
    Position,
    StopDriving,
)
from navigate.navigator import Navigator
from navigate.routes import NoRouteError, show_point
from navigate.service._helm import Helm, SilentRobotError
from navigate.service._intake import Kind
from navigate.service._sparing import Sparing
from navigate.service._telling import Teller
from tca_bus import Context, Module, TaskContext, TaskError, TcaError
from xavier_sim.messages import Sensors

log = logging.getLogger(__name__)


class NavigatorFailedError(TcaError):
    """A drive ended since the navigator itself failed; the cause is what it failed with."""


class GoalDesk:
    """Serves `NavigateToGoal`, one at a time, and `StopDriving`."""

    def __init__(self, navigator: Navigator, module: Module, helm: Helm, teller: Teller) -> None:
        self._navigator, self._helm, self._teller = navigator, helm, teller
        self._errand: Drive | None = None
        self._ended, self._stopped_by, self._task = asyncio.Event(), "", ""
        self._waits, self._words = False, Sparing()
        self._broken: Exception | None = None
        module.serve(NavigateToGoal, self._on_goal)
        module.serve(StopDriving, self._on_stop)

    def stepped(self, *, leapt: bool) -> None:
        """The navigator took in a reading: the drive may have ended.

        After a leap in time it begins anew, since its timers mean nothing any more.
        """
        if self._errand is None:
            return
        if self._errand.done:
            self._ended.set()
        elif leapt and self._helm.sensors is not None:
            if self._words.may_say(Kind.LEAPT):
                log.warning("begins the drive to %s anew", self._name(self._errand.goal))
            self._errand = self._navigator.start(self._errand.goal, self._helm.sensors)
            self._teller.began(self._errand, self._task)

    def broke(self, error: Exception) -> None:
        """The navigator failed, and has given up its goal: the drive under way ends with that."""
        if self._errand is not None:
            self._broken = error
            self._ended.set()

    async def _on_goal(self, goal: NavigateToGoal, context: TaskContext) -> NavigationReport:
        point = (goal.x / CENTIMETRES, goal.y / CENTIMETRES)
        await self._check_on_map(point)
        sensors = await self._first_sensors(point)
        self._ended.clear()
        self._broken = None
        self._task = context.id
        self._errand = errand = self._navigator.start(point, sensors)
        self._teller.began(errand, context.id)
        log.info("drives to %s", self._name(point))
        try:
            if not errand.done:
                await self._helm.answer(sensors)
                errand = await self._until_ended()
        finally:
            self._errand = None
            await self._helm.stop()
            await self._teller.ended()
        await self._helm.until_told()
        return self._ending(errand, point)

    async def _check_on_map(self, point: Point) -> None:
        """Make sure of what needs no robot.

        Raises:
            TaskError: ``no_route``, no robot could stand at the point.
        """
        try:
            self._navigator.planner.check_goal(point)
        except NoRouteError as error:
            await self._helm.until_told()
            text = f"did not get to {self._name(point)}: {error}"
            log.warning("%s (%s)", text, NavigationFailure.NO_ROUTE)
            drive = self._not_begun(point)
            raise self._failed(drive, NavigationFailure.NO_ROUTE, text) from error

    async def _first_sensors(self, point: Point) -> Sensors:
        """What the robot senses, once it does.

        Raises:
            TaskError: ``lost``, it says nothing; ``cancelled``, somebody said stop meanwhile.
        """
        self._stopped_by, self._waits = "", True
        try:
            sensors = await self._helm.first_sensors()
        except SilentRobotError as error:
            raise self._failed(self._not_begun(point), NavigationFailure.LOST, error) from error
        finally:
            self._waits = False
        if self._stopped_by:
            text = f"did not set out for {self._name(point)}: stopped by {self._stopped_by}"
            raise self._failed(self._not_begun(point), NavigationFailure.CANCELLED, text)
        return sensors

    def _not_begun(self, point: Point) -> Drive:
        return Drive(point, began=self._navigator.time)

    def _failed(self, drive: Drive, reason: NavigationFailure, why: object) -> TaskError:
        """How a drive that the navigator itself did not end fails, with its report."""
        report = self._navigator.report(drive).model_copy(update={"outcome": reason})
        return TaskError(reason, str(why), data=report)

    async def _until_ended(self) -> Drive:
        """Wait for the end of the drive under way; gives it.

        Raises:
            TaskError: ``lost``, the robot says nothing any more.
        """
        while not self._ended.is_set():
            try:
                async with asyncio.timeout(self._helm.patience()):
                    await self._ended.wait()
            except TimeoutError:
                self._check_heard()
        assert self._errand is not None
        return self._errand

    def _check_heard(self) -> None:
        assert self._errand is not None
        try:
            self._helm.check_heard()
        except SilentRobotError as error:
            raise self._failed(self._errand, NavigationFailure.LOST, error) from error

    async def _on_stop(self, _query: StopDriving, context: Context) -> Position:
        driving = self._errand is not None and not self._errand.done
        if driving or self._waits:
            self._stopped_by = context.sender
        await self._helm.stop()
        if driving:
            log.warning("stopped by %s", context.sender)
            self._ended.set()
        return self._navigator.position()

    def _ending(self, errand: Drive, point: Point) -> NavigationReport:
        name = self._name(point)
        if self._broken is not None:
            error = self._broken
            text = f"did not get to {name}: the navigator failed, {type(error).__name__}: {error}"
            raise NavigatorFailedError(text) from error
        report = self._navigator.report(errand)
        if self._stopped_by and report.outcome is NavigationFailure.CANCELLED:
            text = f"did not get to {name}: stopped by {self._stopped_by}"
            raise TaskError(NavigationFailure.CANCELLED, text, data=report)
        if errand.failure is None:
            log.info("arrived at %s, %.1f m", name, report.metres)
            return report
        text = f"did not get to {name}: {errand.failure.text}"
        log.warning("%s (%s)", text, errand.failure.reason)
        raise TaskError(errand.failure.reason, text, data=report) from errand.failure

    def _name(self, point: Point) -> str:
        room = self._navigator.floor.room_near(*point)
        return room or show_point(point)
