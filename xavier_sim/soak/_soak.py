"""The soak: a robot that runs errands for hours, its cores in one loop without a network."""

from __future__ import annotations

from typing import Any

from xavier_sim.floors import load_floor, survey_floor
from xavier_sim.messages import Sensors
from xavier_sim.profile import PROFILES, TICK
from xavier_sim.running import Reflex, RobotState, SimClock
from xavier_sim.soak._contract import NavigatorCore
from xavier_sim.soak._course import Course
from xavier_sim.soak._doors import DoorMove
from xavier_sim.soak._jobs import ENDLESS, TIME_LIMIT, Job
from xavier_sim.soak._loading import make_navigator
from xavier_sim.soak._mishaps import Mishaps
from xavier_sim.soak._options import SoakOptions
from xavier_sim.soak._watch import LOOK_EVERY, Watch
from xavier_sim.world import World

EPOCH = 1.0e9
"""Simulated seconds since the epoch at which a soak begins: the ninth of September 2001."""


class Soak:
    """A world, a navigator in it, and errands without end.

    Between two jobs, when it is not `driving`, it can be kept (`snapshot`) and gone on with
    (`restore`), bit for bit.

    Raises:
        FloorError: the floor of the options is none.
        NavigatorError: the navigator of the options cannot be had.
        NoRoomError: there are more people or carts than the floor has room for.
        NoSensorError: a sensor is to fail that the robot has not.
    """

    def __init__(self, options: SoakOptions) -> None:
        self.options = options
        plan = load_floor(options.floor)
        self.world = World(
            plan,
            options.seed,
            PROFILES[options.profile],
            people=options.people,
            carts=options.carts,
            rays=options.rays,
        )
        self.course = Course(plan, options)
        self._robot = RobotState(self.world, SimClock(EPOCH), speed=None)
        surveyed = survey_floor(plan, sigma=options.survey_sigma, seed=options.seed)
        self.navigator: NavigatorCore[Any] = make_navigator(
            options.navigator, surveyed, seed=options.seed, options=options.navigator_options
        )
        for move in self.course.doors.furnish():
            self._move(move)
        self._mishaps = Mishaps(options.fault, options.seed)
        self.course.tally.faults += self._mishaps.begin(self.world)
        self._reflex = Reflex()
        self._reflex.sense(self.world.reading)
        self.driving = False
        self._sensors = self._robot.sensors()
        self._wheels = self.navigator.step(self._sensors)

    @property
    def seconds(self) -> float:
        """Simulated seconds since the soak began."""
        return self.world.tick * TICK

    def run_job(self) -> Job | None:
        """Send the robot on the next errand, and judge how it ended; None when there is none."""
        watch = self.course.next_job(self.world.truth(), self.world.open_doors)
        if watch is None:
            return None
        self.driving = True
        job = self._drive(watch)
        needs_help = self.course.enter(job)
        self._rest(watch)
        if needs_help:
            self._help()
        self.driving = False
        return job

    def snapshot(self) -> dict[str, Any]:
        """The whole state between two jobs, as JSON can hold it."""
        return {
            "world": self.world.snapshot(),
            "navigator": self.navigator.freeze(),
            "mishaps": self._mishaps.snapshot(),
            "reflex": self._reflex.snapshot(),
            **self.course.snapshot(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a snapshot of a soak with the same options."""
        self.world.restore(state["world"])
        self.navigator.thaw(state["navigator"])
        self._mishaps.restore(state["mishaps"])
        self._reflex.restore(state["reflex"])
        self.course.restore(state)
        self._sensors, self._wheels = self._robot.sensors(), _STANDING

    def _drive(self, watch: Watch) -> Job:
        drive = self.navigator.start((watch.goal.x, watch.goal.y), self._sensors)
        while not drive.done and watch.seconds(self.world.tick) < TIME_LIMIT:
            self._tick(watch)
        failure = drive.failure
        reason = (str(failure.reason) if failure else None) if drive.done else ENDLESS
        report, believed = self.navigator.report(drive), self.navigator.pose
        job = watch.judge(reason, report, self.world.truth(), believed, self.world.discs)
        self.navigator.cancel()
        return job

    def _tick(self, watch: Watch) -> None:
        self._sensors = self._step()
        self._wheels = self.navigator.step(self._sensors)
        # Not any(): each of them is to be done.
        if sum(self._move(move) for move in self.course.doors.due(self.world.tick)):
            self.course.tally.door_moves += 1
            here, tick = self.world.truth().space, self.world.tick
            watch.doors_moved(here, self.world.open_doors, tick)
        if self.world.tick % LOOK_EVERY == 0:
            at, believed = self.world.pose[:2], self.navigator.pose[:2]
            discs = self.world.discs
            watch.look(at, believed, self._sensors.speed, self.course.tally, discs)

    def _move(self, move: DoorMove) -> bool:
        """Open or shut a door; true when it moved."""
        before = self.world.open_doors[move.door]
        if move.is_open == before:
            return False
        return self.world.set_door(move.door, is_open=move.is_open).is_open != before

    def _step(self) -> Sensors:
        command = self._reflex.allow(self._wheels.speed, self._wheels.turn)
        self._reflex.sense(self.world.step(*command))
        self.course.tally.faults += self._mishaps.tend(self.world)
        return self._robot.sensors()

    def _rest(self, watch: Watch) -> None:
        """Stand between two jobs, so that the next one begins with wheels that are still."""
        self._wheels = _STANDING
        for _ in range(round(self.options.rest / TICK)):
            self._tick(watch)

    def _help(self) -> None:
        """Put the robot at its start and tell it so."""
        plan = self.world.plan
        start = (plan.start.x, plan.start.y, plan.start_heading)
        self.world.place_robot(*start)
        self.navigator.set_pose(start)


class _Standing:
    speed, turn = 0.0, 0.0


_STANDING = _Standing()
