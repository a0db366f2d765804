"""The driver: a goal becomes a route, a route manoeuvres, and trouble recoveries.

A pure state machine: `Driver.step` takes the view of one tick and gives the wheels. What it can
master by itself it does not report as failure.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from navigate.body import Motion, bump_direction, plausible
from navigate.driving._courtesy import Courtesy
from navigate.driving._doorlog import DoorLog
from navigate.driving._doorpass import TOUCHED_DOUBT, back_out, is_among_jambs, pass_door
from navigate.driving._drive import LIMITS, Drive, Findings, GoalFailedError
from navigate.driving._follow import Way, follow, way_through
from navigate.driving._obeying import STILL_SECONDS
from navigate.driving._safety import guard
from navigate.driving._scout import Scout
from navigate.driving._strangers import Strangers
from navigate.driving._turning import back_off, give_way, turn_by, wait
from navigate.driving._view import (
    STOP,
    Astray,
    Bumped,
    BumpedInDoor,
    Disobeyed,
    DoorObstructed,
    DoorShut,
    Manoeuvre,
    OffCourse,
    Rerouted,
    Stuck,
    Trouble,
    View,
    WayBlocked,
    Wheels,
)
from navigate.driving._wander import find_oneself, make_sure
from navigate.maps import Passage, Point, frame, is_room
from navigate.messages import NavigationFailure
from navigate.routes import (
    Hindrances,
    Memory,
    NoRouteError,
    Planner,
    Step,
    remaining,
    side_of,
)

ARRIVED = 0.1
"""Metres from a goal in open floor that count as there."""

ARRIVED_BEHIND_DOOR = 0.2
"""The same right behind a door, whose jambs tell better than the map where the place is."""

NO_PROGRESS_SECONDS = 75.0
PROGRESS = 0.2
BUMP_PAUSE = 0.5
"""Seconds for which one contact counts as one bump."""

SILENCE = 1.0
"""Seconds between two readings in which the wheels may have been told something else."""

DISOBEYED_PAUSE = 5.0
"""Seconds after which wheels that do not turn are told again."""

REPLAN_SECONDS = 5.0
"""How often the robot looks on its way whether another one is better."""

WORTH_SECONDS, WORTH_SHARE = 10.0, 0.2
"""What another way must save for the robot to take it: seconds, and a share of what is left."""

TURN_NEAR = 0.5
"""Metres from a corner on its way at which the robot may turn into the next way, if it must."""

TURN_BEFORE = 0.7
"""Radians between two straight ways beyond which the robot slows down for the turn."""


class Driver:
    """Drives to one goal at a time."""

    def __init__(
        self,
        planner: Planner,
        memory: Memory,
        strangers: Strangers,
        doors: DoorLog | None = None,
    ) -> None:
        self._planner, self._memory, self._strangers = planner, memory, strangers
        self.doors = doors or DoorLog()
        self._view: View | None = None
        self.drive: Drive | None = None

    def start(self, goal: Point, view: View) -> Drive:
        """Take on a goal in metres; the drive's fields tell how it goes."""
        self._view = view
        self.drive = drive = Drive(goal, view.time, Courtesy(self._strangers), nearest_at=view.time)
        drive.course = self._run(drive, view)
        self._advance(drive, None)
        return drive

    def cancel(self) -> None:
        """Give the goal up and stand."""
        if self.drive is not None:
            self.drive.cancel()
        self.drive = None

    @property
    def busy(self) -> bool:
        """Whether there is a goal under way."""
        return self.drive is not None and not self.drive.done

    def take_findings(self) -> Findings:
        """What the drive found out at this tick about where the robot is; once."""
        if self.drive is None:
            return Findings()
        findings, self.drive.findings = self.drive.findings, Findings()
        return findings

    def step(self, view: View) -> Wheels:
        """Take in one tick and answer with the wheels."""
        drive, before = self.drive, self._view
        self._view = view
        if drive is None or drive.done:
            return STOP
        if before is not None:
            drive.metres += _driven(before, view)
            if abs(view.time - before.time) > SILENCE:
                drive.obedience.forget()
        wheels = guard(self._advance(drive, view), view)
        drive.obedience.told(wheels, view)
        return wheels

    def _advance(self, drive: Drive, view: View | None) -> Wheels:
        course = drive.course
        assert course is not None
        try:
            if view is None:
                return next(course)
            trouble = self._interrupt(drive, view)
            event = trouble or self._better(drive, view)
            return course.throw(event) if event else course.send(view)
        except StopIteration:
            drive.done = True
        except GoalFailedError as failure:
            drive.done, drive.failure = True, failure
            self.doors.give_up()
        return STOP

    def _interrupt(self, drive: Drive, view: View) -> Trouble | None:
        direction = bump_direction(view.bump)
        if direction is not None and view.time - drive.bumped_at > BUMP_PAUSE:
            drive.bumped_at = view.time
            return Bumped(direction, view)
        stood = drive.obedience.stood(view)
        if stood > STILL_SECONDS:
            drive.obedience.forget()
            return Disobeyed(stood)
        left = remaining(view.at, drive.steps)
        if left < drive.nearest - PROGRESS:
            drive.nearest, drive.nearest_at = left, view.time
        if view.lost:
            drive.nearest_at = view.time
        if view.time - drive.nearest_at > NO_PROGRESS_SECONDS:
            drive.nearest_at = view.time
            return Stuck(NO_PROGRESS_SECONDS)
        return None

    def _run(self, drive: Drive, view: View) -> Manoeuvre[None]:
        self._check_goal(drive)
        trouble: Trouble | None = None
        while True:
            try:
                if trouble is not None:
                    met, trouble = trouble, None
                    view = yield from self._recover(drive, view, met)
                view = yield from self._attempt(drive, view)
            except Rerouted:
                view = self._latest(view)
            except Trouble as met:
                trouble, view = met, self._latest(view)
                drive.meet(met)
            else:
                return

    def _latest(self, view: View) -> View:
        return self._view or view

    def _attempt(self, drive: Drive, view: View) -> Manoeuvre[View]:
        """Plan from where the robot is, and drive the whole way."""
        if not view.lost:
            drive.steps = self._plan(drive, view)
            drive.nearest, drive.nearest_at = math.inf, view.time
            drive.planned_at = view.time
        view = yield STOP
        start, behind_door = view.at, False
        while drive.steps:
            _check(view)
            step = drive.steps[0]
            if step.door is not None:
                view = yield from self._pass(drive, view, step, step.door)
            elif not _lined_up(view, drive.steps):
                way = self._way(drive.steps, start)
                view = yield from _go(view, way, drive, behind_door=behind_door)
            behind_door = step.door is not None
            start = drive.steps.pop(0).to
        return (yield from make_sure(view))

    def _pass(self, drive: Drive, view: View, step: Step, door: Passage) -> Manoeuvre[View]:
        drive.in_door, sign = True, side_of(door, step.to)
        try:
            passed = yield from pass_door(view, door, sign, self.doors)
        except DoorShut:
            self.doors.find_shut(door.name)
            raise
        except (DoorObstructed, OffCourse, Disobeyed):
            raise
        except Bumped as met:
            self.doors.get_stuck(door.name)
            if is_among_jambs(met, door, sign):
                raise BumpedInDoor(met, door, sign) from met
            raise
        except Trouble:
            self.doors.get_stuck(door.name)
            raise
        finally:
            drive.in_door = False
        self._memory.opened(door.name)
        self.doors.get_through(door.name)
        drive.findings = Findings(look=passed.look)
        return passed.view

    def _better(self, drive: Drive, view: View) -> Rerouted | None:
        """Look every few seconds whether another way has become much better than this one."""
        due = view.time - drive.planned_at > REPLAN_SECONDS
        if not due or drive.in_door or view.lost or not drive.steps:
            return None
        drive.planned_at = view.time
        outlook = self._memory.outlook(view.time)
        left = self._planner.seconds_now(view.at, drive.steps, outlook)
        try:
            other = self._planner.plan(view.at, drive.goal, outlook)
        except NoRouteError:
            return None
        saved = left - sum(step.seconds for step in other)
        return Rerouted() if saved > max(WORTH_SECONDS, WORTH_SHARE * left) else None

    def _way(self, steps: Sequence[Step], start: Point) -> Way:
        """The first of the ``steps``, from where it starts."""
        floor, step = self._planner.floor, steps[0]
        mouths = [mouth for mouth in floor.passages if step.space in mouth.spaces]
        beside = [floor.space_nearest(*start)]
        if len(steps) > 1 and steps[1].door is None:
            beside.append(floor.spaces[steps[1].space])
        return way_through(
            floor.spaces[step.space],
            start,
            step.to,
            [mouth.jambs for mouth in mouths],
            openings=[mouth.jambs for mouth in mouths if not mouth.door],
            beside=(space for space in beside if not is_room(space)),
        )

    def _check_goal(self, drive: Drive) -> None:
        """A lost robot plans no way, but need not look for itself to know that there is none.

        Raises:
            GoalFailedError: the robot could not stand at the goal.
        """
        try:
            self._planner.check_goal(drive.goal)
        except NoRouteError as error:
            raise _no_way(drive, error) from error

    def _plan(self, drive: Drive, view: View) -> list[Step]:
        """A way to the goal; for want of a free one, one through what was found blocked before.

        Raises:
            GoalFailedError: the map has none, or all lead through what this drive found shut.
        """
        shut = frozenset(met.door for met in drive.troubles if isinstance(met, DoorShut))
        outlook = self._memory.outlook
        for hindrances in (
            outlook(view.time),
            outlook(view.time, way_is_free=True),
            Hindrances(shut),
        ):
            try:
                return self._planner.plan(view.at, drive.goal, hindrances)
            except NoRouteError as error:
                why = error
        raise _no_way(drive, why)

    def _has_way_round(self, drive: Drive, view: View) -> bool:
        try:
            self._planner.plan(view.at, drive.goal, self._memory.outlook(view.time))
        except NoRouteError:
            return False
        return True

    def _recover(self, drive: Drive, view: View, trouble: Trouble) -> Manoeuvre[View]:
        drive.steps, drive.nearest_at = [], view.time
        if isinstance(trouble, Bumped):
            return (yield from _back_off(drive, view, trouble))
        if isinstance(trouble, DoorShut):
            self._memory.shut(trouble.door, view.time)
        elif isinstance(trouble, DoorObstructed):
            return (yield from give_way(view, trouble.at))
        elif isinstance(trouble, OffCourse):
            drive.findings = Findings(pose=trouble.pose)
        elif isinstance(trouble, WayBlocked):
            self._memory.blocked(trouble.at, view.time)
            if not self._has_way_round(drive, view):
                return (yield from give_way(view, trouble.at))
        elif isinstance(trouble, Astray):
            scout = Scout(drive, self._attempt, self._planner.floor)
            view = yield from find_oneself(view, scout)
            self._memory.forget_since(drive.began)
            return view
        elif isinstance(trouble, Stuck):
            return (yield from turn_by(view, math.pi / 2))
        elif isinstance(trouble, Disobeyed):
            return (yield from wait(view, DISOBEYED_PAUSE))
        return (yield from wait(view, 0.5))


def _back_off(drive: Drive, view: View, met: Bumped) -> Manoeuvre[View]:
    """Back off from a contact; from a jamb out of the door, to find out where the robot is."""
    if not isinstance(met, BumpedInDoor):
        return (yield from back_off(view, met.direction))
    drive.findings = Findings(doubt=TOUCHED_DOUBT)
    view = yield from back_off(view, met.direction)
    view, pose, look = yield from back_out(view, met.passage, met.sign)
    drive.findings = Findings(pose=pose, look=look)
    return (yield STOP)


def _driven(before: View, now: View) -> float:
    """Metres from one tick to the next; none where odometry was set anew meanwhile."""
    metres = math.dist(before.odom[:2], now.odom[:2])
    return metres if plausible(Motion(metres, 0.0, 0.0), now.time - before.time) else 0.0


def _go(view: View, way: Way, drive: Drive, *, behind_door: bool) -> Manoeuvre[View]:
    """Follow ``way``, the first step that is left of the drive."""
    steps = drive.steps
    last = len(steps) == 1
    tolerance = (ARRIVED_BEHIND_DOOR if behind_door else ARRIVED) if last else 0.12
    ends = last or steps[1].door is not None or _turns(way.start, way.goal, steps[1].to)
    if not ends:
        tolerance = 0.3
    settle = 0.0 if last or steps[1].door is not None else TURN_NEAR
    return (
        yield from follow(view, way, drive.courtesy, tolerance=tolerance, ends=ends, settle=settle)
    )


def _no_way(drive: Drive, why: NoRouteError) -> GoalFailedError:
    """What to say where no way is left: what this drive met, or that the map has none."""
    for met in reversed(drive.troubles):
        if isinstance(met, DoorShut | WayBlocked):
            text, last = f"{met}, and there is no other way", met is drive.troubles[-1]
            return GoalFailedError(LIMITS[type(met)][1], text, by_trouble=last)
    return GoalFailedError(NavigationFailure.NO_ROUTE, str(why))


def _check(view: View) -> None:
    if view.lost:
        raise Astray


def _lined_up(view: View, steps: list[Step]) -> bool:
    """Whether the next step passes a door that the robot stands right before already."""
    if len(steps) < 2 or steps[1].door is None:
        return False
    door: Passage = steps[1].door
    ahead, left = frame(door, *view.at)
    ahead *= side_of(door, steps[1].to)
    return -1.3 < ahead < -0.55 and abs(left) < 0.15


def _turns(start: Point, corner: Point, end: Point) -> bool:
    into = math.atan2(corner[1] - start[1], corner[0] - start[0])
    out = math.atan2(end[1] - corner[1], end[0] - corner[0])
    short = math.dist(corner, end) < 0.05
    return not short and abs((out - into + math.pi) % (2 * math.pi) - math.pi) > TURN_BEFORE
