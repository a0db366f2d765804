"""The soak over the bus: the same errands, doors and judge, and the whole office in lockstep."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from navigate.messages import NavigateToGoal, NavigationReport, SetPosition, WhereAmI
from soaks.attendant import Attendant
from soaks.office import bus_of_soak, specs_of_soak
from soaks.spending import Spending
from tca_bus import Module, TaskFailedError
from tca_bus.launcher import Launcher
from xavier_sim.floors import load_floor
from xavier_sim.messages import Fault, FloorPlan, Kidnap, WhereReally
from xavier_sim.profile import TICK
from xavier_sim.soak import ENDLESS, Course, Job, Outcome, SoakOptions, Watch

CENTIMETRES = 100.0

LISTEN_TICKS = 10
"""Ticks in which every sonar is heard once."""

Tell = Callable[[Job, float], object]
"""Is told every job that ended, and the simulated seconds so far."""


class BusSoak:
    """Errands for a robot on the bus, sent through central, judged as those in one process.

    Args:
        module: of the soak, on the bus.
        plan: the floor as it is.
        course: goals, doors and judge.
        attendant: who moves the doors.
        rest: seconds for which the robot stands between two jobs.
    """

    def __init__(
        self, module: Module, plan: FloorPlan, course: Course, attendant: Attendant, rest: float
    ) -> None:
        self._module, self._plan = module, plan
        self._course, self._attendant = course, attendant
        self._rest_ticks = round(rest / TICK)
        self.seconds = 0.0

    async def run_job(self) -> Job | None:
        """Send the robot on the next errand, and judge how it ended; None when there is none."""
        attendant = self._attendant
        watch = self._course.next_job(await attendant.see(), attendant.open_doors)
        if watch is None:
            return None
        attendant.watch, attendant.gave_up = watch, False
        reason, report = await self._drive(watch)
        seen, around = await attendant.see_all()
        await attendant.until_acted(seen.tick)
        reason = ENDLESS if attendant.gave_up else reason
        here = report.position
        job = watch.judge(reason, report, seen, (here.x, here.y, here.theta), around)
        needs_help = self._course.enter(job)
        await self._rest(seen.tick + self._rest_ticks)
        if needs_help:
            await self._help()
        return job

    async def _drive(self, watch: Watch) -> tuple[str | None, NavigationReport]:
        """Have the robot driven, and give why it did not arrive, and what is said of it."""
        goal = NavigateToGoal(x=CENTIMETRES * watch.goal.x, y=CENTIMETRES * watch.goal.y)
        task = await self._module.expand(goal)
        try:
            return None, await task.result()
        except TaskFailedError as error:
            failure = error.failure
        if failure.data and "position" in failure.data:
            return failure.name, NavigationReport.model_validate(failure.data)
        position = await self._module.query(WhereAmI())
        nothing = NavigationReport(position=position, metres=0.0, seconds=0.0, recoveries=0)
        return failure.name, nothing

    async def _rest(self, until: int) -> None:
        await self._module.clock.sleep_until(self._attendant.time(until))
        await self._attendant.until_acted(until)
        self.seconds = until * TICK

    async def _help(self) -> None:
        """Put the robot at the place nearest to its start, and tell it so.

        In between it listens: what it is told is fitted to what its sonars hear there.
        """
        start, places = self._plan.start, self._plan.places
        room = min(
            places, key=lambda name: math.dist((places[name].x, places[name].y), (start.x, start.y))
        )
        await self._module.query(Fault(fault=Kidnap(room=room)))
        await self._rest((await self._attendant.see()).tick + LISTEN_TICKS)
        await (await self._module.execute(SetPosition(room=room))).result()


async def soak_over_bus(options: SoakOptions, hours: float, tell: Tell) -> Outcome:
    """Soak for so many simulated hours with all processes.

    Raises:
        ExceptionGroup: a process was given up, or one did not answer.
    """
    plan = load_floor(options.floor)
    course = Course(plan, options)
    with TemporaryDirectory(prefix="xavier-soak-") as folder:
        bus = bus_of_soak()
        specs = specs_of_soak(options, bus, Path(folder))
        async with (
            Launcher(specs, bus, log_dir=Path(folder) / "logs") as launcher,
            Module("soak", options=bus, sole=True) as module,
        ):
            spending = Spending(launcher, [spec.name for spec in specs])
            began, crowded = await module.query(WhereReally()), options.people + options.carts > 0
            attendant = Attendant(module, plan, course, began, crowded=crowded)
            await attendant.move(course.doors.furnish())
            module.start(attendant.attend(), name="attendant")
            soak = BusSoak(module, plan, course, attendant, options.rest)
            while soak.seconds < 3600.0 * hours:
                job = await soak.run_job()
                if job is None:
                    break
                spending.read(early=soak.seconds <= 3600.0)
                tell(job, soak.seconds)
    return Outcome(options, course.tally, soak.seconds, spending.cost)
