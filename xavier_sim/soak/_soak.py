"""The soak: a robot that runs errands for hours, its cores in one loop without a network."""

from __future__ import annotations

from typing import Any

from xavier_sim.floors import load_floor, survey_floor
from xavier_sim.messages import Sensors
from xavier_sim.profile import PROFILES, TICK
from xavier_sim.running import Reflex, RobotState, SimClock
from xavier_sim.soak._contract import NavigatorCore
from xavier_sim.soak._doors import DoorKeeper
from xavier_sim.soak._drive import Watch
from xavier_sim.soak._errands import DoorTrials, Errands, Goal, RandomErrands
from xavier_sim.soak._jobs import ENDLESS, TIME_LIMIT, Job
from xavier_sim.soak._loading import make_navigator
from xavier_sim.soak._mishaps import Mishaps
from xavier_sim.soak._options import SoakOptions
from xavier_sim.soak._reaching import Reach
from xavier_sim.soak._tally import Tally
from xavier_sim.world import World

EPOCH = 1.0e9
"""Simulated seconds since the epoch at which a soak begins: the ninth of September 2001."""

PATIENCE = 3
"""Jobs with an open way that may fail one after the other before somebody helps the robot."""


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
            rays="auto",
        )
        self.tally = Tally()
        self._robot = RobotState(self.world, SimClock(EPOCH), speed=None)
        surveyed = survey_floor(plan, sigma=options.survey_sigma, seed=options.seed)
        self.navigator: NavigatorCore[Any] = make_navigator(
            options.navigator, surveyed, seed=options.seed, options=options.navigator_options
        )
        self._reach = Reach(plan)
        self._doors = DoorKeeper(
            self.world.geometry.door_names,
            shut_share=options.shut_share,
            moves_per_hour=options.door_moves_per_hour,
            seed=options.seed,
        )
        self._doors.furnish(self.world)
        self._errands: Errands = (
            DoorTrials(plan, options.doors_in_and_out)
            if options.doors_in_and_out
            else RandomErrands(plan, options.seed)
        )
        self._mishaps = Mishaps(options.fault, options.seed)
        self._mishaps.begin(self.world)
        self._reflex = Reflex()
        self._reflex.sense(self.world.reading)
        self._unlucky = 0
        self.driving = False
        self._sensors = self._robot.sensors()
        self._wheels = self.navigator.step(self._sensors)

    @property
    def seconds(self) -> float:
        """Simulated seconds since the soak began."""
        return self.world.tick * TICK

    def run_job(self) -> Job | None:
        """Send the robot on the next errand, and judge how it ended; None when there is none."""
        goal = self._errands.next(self.world.truth().space)
        if goal is None:
            return None
        self.driving = True
        watch = Watch(self.world, self._reach, goal, number=len(self.tally.jobs))
        job = self._drive(goal, watch)
        self.tally.jobs.append(job)
        self._rest(watch)
        self._help_if_stuck(job)
        self.driving = False
        return job

    def snapshot(self) -> dict[str, Any]:
        """The whole state between two jobs, as JSON can hold it."""
        return {
            "world": self.world.snapshot(),
            "navigator": self.navigator.freeze(),
            "doors": self._doors.snapshot(),
            "mishaps": self._mishaps.snapshot(),
            "reflex": self._reflex.snapshot(),
            "errands": self._errands.snapshot(),
            "unlucky": self._unlucky,
            "tally": self.tally.snapshot(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a snapshot of a soak with the same options."""
        self.world.restore(state["world"])
        self.navigator.thaw(state["navigator"])
        self._doors.restore(state["doors"])
        self._mishaps.restore(state["mishaps"])
        self._reflex.restore(state["reflex"])
        self._errands.restore(state["errands"])
        self._unlucky = state["unlucky"]
        self.tally.restore(state["tally"])
        self._sensors, self._wheels = self._robot.sensors(), _STANDING

    def _drive(self, goal: Goal, watch: Watch) -> Job:
        drive = self.navigator.start((goal.x, goal.y), self._sensors)
        while not drive.done and watch.seconds < TIME_LIMIT:
            self._tick(watch)
        failure = drive.failure
        reason = (str(failure.reason) if failure else None) if drive.done else ENDLESS
        job = watch.judge(reason, self.navigator.report(drive))
        self.navigator.cancel()
        return job

    def _tick(self, watch: Watch) -> None:
        self._sensors = self._step()
        self._wheels = self.navigator.step(self._sensors)
        if self._doors.tend(self.world):
            self.tally.door_moves += 1
            watch.doors_moved()
        watch.look(self.navigator.pose, self._sensors, self.tally)

    def _step(self) -> Sensors:
        command = self._reflex.allow(self._wheels.speed, self._wheels.turn)
        self._reflex.sense(self.world.step(*command))
        self._mishaps.tend(self.world)
        return self._robot.sensors()

    def _rest(self, watch: Watch) -> None:
        """Stand between two jobs, so that the next one begins with wheels that are still."""
        self._wheels = _STANDING
        for _ in range(round(self.options.rest / TICK)):
            self._tick(watch)

    def _help_if_stuck(self, job: Job) -> None:
        """After too many failures running, put the robot at its start and tell it so."""
        failed = job.reason is not None and not job.refused_rightly
        self._unlucky = self._unlucky + 1 if failed or job.false_arrival else 0
        if self._unlucky >= PATIENCE:
            self._unlucky = 0
            self.tally.rescues += 1
            plan = self.world.plan
            start = (plan.start.x, plan.start.y, plan.start_heading)
            self.world.place_robot(*start)
            self.navigator.set_pose(start)


class _Standing:
    speed, turn = 0.0, 0.0


_STANDING = _Standing()
