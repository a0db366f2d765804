"""The helm: takes in what the robot senses, and answers with the wheels, tick by tick."""

from __future__ import annotations

import asyncio
import enum
import logging
import time
from collections.abc import Awaitable, Callable

from navigate.driving import STOP, Wheels, must_stop
from navigate.navigator import Navigator
from navigate.service._followed import Followed
from navigate.service._intake import Intake, Judgement, Kind
from navigate.service._sparing import Sparing
from tca_bus import BusGoneError, ClosedError, Context, Module, NoHandlerError
from xavier_sim.messages import DoorMoved, Drive, Sensors

SENSOR_SECONDS = 30.0
"""Wall seconds that a goal waits for a robot that says nothing, or nothing any more."""

CLOCK_SECONDS = 2.0
"""Wall seconds that the end of a drive waits for the time of its last tick to be told."""

log = logging.getLogger(__name__)


class SilentRobotError(Exception):
    """The robot has sent no readings of use for ``seconds`` on the wall."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        super().__init__(f"the robot has sent no sensor readings of use for {seconds:.0f} s")


class Broken(enum.Enum):
    """What can fail in the navigator itself."""

    STEP = enum.auto()


class Helm:
    """Steps a navigator with each reading of one robot and answers it.

    Args:
        navigator: what decides.
        module: that hears the robot.
        stepped: called after the navigator took in a reading; told whether time leapt before.
        broke: called instead with what the navigator failed with, once it has given up its goal.
    """

    def __init__(
        self,
        navigator: Navigator,
        module: Module,
        stepped: Callable[[bool], Awaitable[None]],
        broke: Callable[[Exception], None],
    ) -> None:
        self._navigator, self._module = navigator, module
        self._stepped, self._broke = stepped, broke
        self.sensors: Sensors | None = None
        self._heard = asyncio.Event()
        self._silent_since = 0.0
        self._unheard = 0
        self._followed = Followed(self._is_present)
        self._intake = Intake()
        self._amiss: Kind | None = None
        self._words = Sparing()
        module.serve(Sensors, self._on_sensors)
        module.serve(DoorMoved, self._on_door_moved)

    async def first_sensors(self) -> Sensors:
        """The latest reading; one who has been silent has time anew from now on.

        Raises:
            SilentRobotError: the robot has sent nothing for `SENSOR_SECONDS`.
        """
        try:
            async with asyncio.timeout(SENSOR_SECONDS):
                await self._heard.wait()
        except TimeoutError as error:
            raise SilentRobotError(SENSOR_SECONDS) from error
        assert self.sensors is not None
        self._silent_since = time.monotonic()
        return self.sensors

    def patience(self) -> float:
        """Wall seconds that the robot may go on saying nothing of use; 0.0 when they are over."""
        return max(0.0, self._silent_since + SENSOR_SECONDS - time.monotonic())

    def check_heard(self) -> None:
        """Make sure that the robot still sends readings.

        Raises:
            SilentRobotError: it has sent none of use for `SENSOR_SECONDS`.
        """
        if self.patience() == 0.0:
            raise SilentRobotError(SENSOR_SECONDS)

    async def stop(self) -> None:
        """Give up the goal, stand, and say so to the robot at once."""
        self._navigator.cancel()
        if self.sensors is not None:
            await self.answer(self.sensors)

    async def answer(self, sensors: Sensors) -> None:
        """Answer the sensors of a tick; a robot that went away is no reason to end."""
        await self._command(sensors, self._navigator.wheels)

    async def _command(self, sensors: Sensors, wheels: Wheels) -> None:
        busy = self._navigator.busy
        drive = Drive(tick=sensors.tick, speed=wheels.speed, turn_rate=wheels.turn, busy=busy)
        try:
            await self._module.inform(drive)
        except ClosedError:
            # This module is on its way out, and the robot sees that it goes.
            return
        except (NoHandlerError, BusGoneError) as error:
            self._unheard += 1
            if self._unheard == 1:
                log.warning("nobody takes the wheels' commands: %s", error)
        else:
            self._unheard = 0

    async def until_told(self) -> None:
        """Let all hear the time of the last tick before they hear what came of a drive.

        In lockstep time stands still once the drive has ended; who reads the clock on hearing of
        it should find the same time in every run. On the wall clock nobody does.
        """
        sensors, clock = self.sensors, self._module.clock
        if sensors is None or not sensors.lockstep or not clock.is_simulated:
            return
        try:
            async with asyncio.timeout(CLOCK_SECONDS):
                await clock.watch_until(sensors.time)
        except TimeoutError:
            log.warning("nobody tells the time of tick %d", sensors.tick)

    def _is_present(self, name: str) -> bool:
        return any(module.name == name for module in self._module.modules())

    def _is_of_the_robot(self, sender: str) -> bool:
        verdict = self._followed.judge(sender, time.monotonic())
        if verdict.word is not None:
            log.warning("%s", verdict.word)
        if verdict.other:
            self._intake.expect_another()
        return verdict.taken

    async def _on_sensors(self, sensors: Sensors, context: Context) -> None:
        if not self._is_of_the_robot(context.sender):
            return
        judged = self._intake.judge(sensors)
        self._say(sensors, judged)
        if judged.kind is not Kind.USELESS:
            self._silent_since = time.monotonic()
        match judged.kind:
            case Kind.LATE:
                return
            case Kind.USELESS:
                self._navigator.wheels = STOP
            case Kind.NEW | Kind.LEAPT:
                await self._take_in(sensors, leapt=judged.kind is Kind.LEAPT)
        await self.answer(sensors)

    async def _take_in(self, sensors: Sensors, *, leapt: bool) -> None:
        self.sensors = sensors
        await self._stop_first(sensors)
        error = self._think(sensors, leapt=leapt)
        self._heard.set()
        if error is None:
            await self._stepped(leapt)
        else:
            self._break_off(sensors, error)

    def _think(self, sensors: Sensors, *, leapt: bool) -> Exception | None:
        """Let the navigator decide; gives what it failed with, if it did."""
        try:
            if leapt:
                self._navigator.forget_after(sensors.time)
            self._navigator.step(sensors)
        except Exception as error:
            return error
        return None

    def _break_off(self, sensors: Sensors, error: Exception) -> None:
        """Stand, since nothing was decided, and give up the goal; the next reading is a new try."""
        self._navigator.cancel()
        if self._words.may_say(Broken.STEP):
            log.error("the navigator failed at tick %d and stands", sensors.tick, exc_info=error)
        self._broke(error)

    def _say(self, sensors: Sensors, judged: Judgement) -> None:
        """Say once what is amiss, until readings are sound again; sparingly, if it comes and goes.

        What counts is the kind: the words may tell other figures at each tick.
        """
        if judged.word is None:
            self._amiss = None
        elif judged.kind is not self._amiss and self._words.may_say(judged.kind):
            self._amiss = judged.kind
            log.warning("sensors of tick %d: %s", sensors.tick, judged.word)

    async def _stop_first(self, sensors: Sensors) -> None:
        """Stop before thinking, where the robot is about to drive into something.

        In lockstep the world waits for the whole thought, so nothing is gained.
        """
        if not sensors.lockstep and must_stop(self._navigator.wheels, sensors):
            await self._command(sensors, STOP)

    async def _on_door_moved(self, moved: DoorMoved, _context: Context) -> None:
        if moved.open:
            self._navigator.hear_opened(moved.room)
