"""The navigator without a network: sensors in, wheels out, goals in between."""

from __future__ import annotations

import math
from typing import Any, ClassVar

import numpy as np

from navigate.body import (
    Motion,
    Percept,
    Perception,
    Pose,
    bump_direction,
    motion_between,
    plausible,
    wrap,
)
from navigate.driving import (
    STOP,
    STRANGERS_WITHIN,
    DoorLog,
    DoorWatch,
    Drive,
    Driver,
    Strangers,
    Surroundings,
    View,
    Wheels,
)
from navigate.freezing import freeze, thaw
from navigate.maps import Floats, Floor, Point
from navigate.messages import NavigationReport, Position
from navigate.position import DEFAULT_LOCALIZER, Confidence, Localizer, make_localizer
from navigate.routes import Distances, Memory, Planner
from xavier_sim.messages import SONAR_COUNT, Sensors

UNSEEN_SPREAD = 0.5
"""Doubt in metres after odometry was set anew: nobody saw how the robot moved."""

FIX_SPREAD, FIX_TURN_SPREAD = 0.08, 0.04
"""Doubt in metres and radians about a pose that an open door gave away."""

ECHO_RANGE = 3.0
"""Metres within which echoes matter to a manoeuvre."""

AT_GOAL = 0.6
"""Metres from a goal within which belief counts as being there."""

SIGHT = 2.5
"""Metres from a door within which its plate can be read."""

SURE_OF_DOORS = 0.2
"""Doubt in metres about its position up to which the robot knows which door it passes."""

SEARCH_EVERY = 8
"""Ticks between two searches while the robot stands and is lost."""

ORIGIN: Pose = (0.0, 0.0, 0.0)
"""Where dead reckoning begins, before the robot has told of any."""

SEARCH_RADII = (1.0, 2.0, 4.0, 8.0, 15.0)


CLOSE = 0.5
"""Metres that a sonar ahead may read when the reflex of a base holds its wheels."""

_AHEAD = (0, 1, 2, -2, -1)

LOOKS = tuple(wrap(number * math.pi / 12) for number in range(24))
"""Turns in radians by which a robot may look elsewhere than believed."""

TURNED = math.radians(20.0)
"""What is turned by more than this looks elsewhere."""


class Navigator:
    """One robot on one floor.

    Args:
        floor: the map.
        seed: of what the localizer draws, if it draws.
        localizer: knows where the robot is; a POMDP, unless another is given.
    """

    STATE: ClassVar[tuple[str, ...]] = (
        "time", "_odom", "_heard", "_still_ticks", "_searches",
        "localizer", "memory", "perception", "surroundings", "strangers", "doors",
        "_door_watch", "_confidence",
    )  # fmt: skip

    def __init__(self, floor: Floor, *, seed: int = 0, localizer: Localizer | None = None) -> None:
        self.floor = floor
        self.localizer = localizer or make_localizer(DEFAULT_LOCALIZER, floor, seed=seed)
        self.planner = Planner(floor)
        self.memory = Memory()
        self.perception = Perception()
        self.surroundings = Surroundings()
        self.strangers = Strangers()
        self.doors = DoorLog()
        self._door_watch = DoorWatch(floor.doors.values())
        self.driver = Driver(self.planner, self.memory, self.strangers, self.doors)
        self.distances = Distances(self.planner)
        self._confidence = Confidence(floor, self.localizer)
        self.time = 0.0
        self.wheels = STOP
        self._odom: Pose | None = None
        silence = np.full(SONAR_COUNT, np.inf)
        self._percept = Percept(silence, 0, silence, 0)
        self._still_ticks, self._searches = 0, 0
        self._has_sensed = False

    def step(self, sensors: Sensors) -> Wheels:
        """Take in what the robot senses at a tick, and answer with the wheels."""
        self._has_sensed = True
        motion = self._reckon(sensors)
        still = motion.still()
        self._percept = self.perception.take_in(sensors, self._odom or ORIGIN)
        self._locate(motion)
        self._still_ticks = self._still_ticks + 1 if still else 0
        self._listen(sensors)
        self._search()
        self._watch_doors()
        view = self._view(sensors)
        self.strangers.listen(view, self.floor.open_around(*view.at, within=STRANGERS_WITHIN))
        self.wheels = self.driver.step(view)
        self._learn()
        return self.wheels

    def start(self, goal: Point, sensors: Sensors) -> Drive:
        """Begin to drive to a point in metres; look at the drive after every step."""
        return self.driver.start(goal, self._view(sensors))

    def cancel(self) -> None:
        """Give up the goal under way, and stand."""
        self.driver.cancel()
        self.wheels = STOP

    @property
    def busy(self) -> bool:
        """Whether a goal is under way."""
        return self.driver.busy

    def position(self) -> Position:
        """Where the robot is believed to be."""
        here = self.localizer.estimate
        room = self.floor.room_near(here.x, here.y)
        return Position(
            x=round(here.x, 4),
            y=round(here.y, 4),
            theta=round(here.theta, 4),
            deviation=round(here.deviation, 4),
            heading_deviation=round(here.heading_deviation, 4),
            room=room,
            confidence=round(self._confidence.at(room, self._ranges, self._odom), 4),
            time=self.time,
            lost=self.localizer.lost,
            heard=self._has_sensed,
        )

    def report(self, drive: Drive) -> NavigationReport:
        """What a drive has come to."""
        return NavigationReport(
            position=self.position(),
            metres=round(drive.metres, 3),
            seconds=round(self.time - drive.began, 3),
            recoveries=drive.recoveries,
            outcome=drive.failure.reason if drive.failure else "arrived",
            goal_mass=self.mass_at(drive.goal),
            entropy=round(self.localizer.belief().entropy, 4),
            door=self._room_behind(drive.door) if drive.door else None,
        )

    def _room_behind(self, door: str) -> str | None:
        """The room that one enters by a door."""
        spaces = self.floor.doors[door].spaces
        return next((space for space in spaces if space in self.floor.places), None)

    def mass_at(self, goal: Point) -> float:
        """The share of belief at a point in metres, 0 to 1."""
        return round(self.localizer.mass_near(*goal, within=AT_GOAL), 4)

    def mass_seeing(self, room: str) -> float:
        """The share of belief from where the door plate of a room can be seen, 0 to 1.

        Raises:
            UnknownRoomError: no such room.
        """
        masses = [self.localizer.mass_near(*at, within=SIGHT) for at in self._doors_of(room)]
        return round(max(masses, default=0.0), 4)

    def notice(self, room: str, *, sure: float) -> Position:
        """Take in that the door plate of ``room`` is seen, right with probability ``sure``.

        Raises:
            UnknownRoomError: no such room.
        """
        self.localizer.notice(self._doors_of(room), within=SIGHT, sure=sure)
        return self.position()

    def _doors_of(self, room: str) -> list[Point]:
        self.floor.place(room)
        doors = self.floor.doors.values()
        return [door.centre for door in doors if room.lower() in door.spaces]

    def hear_opened(self, room: str) -> None:
        """Forget that the doors of a room, or a door of that name, were found shut."""
        for door in self.planner.floor.doors.values():
            if room in {door.name, *door.spaces}:
                self.memory.opened(door.name)

    def forget_after(self, time: float) -> None:
        """Forget what was found in the way after a time, in seconds: the clock was set back."""
        self.memory.forget_since(time)
        self.strangers.forget()

    def set_position(self, room: str, *, theta: float | None = None) -> Position:
        """Believe to be at ``room``, as somebody said who sees the robot there.

        That is at its place, or before its door, whichever the sonars speak for. The robot looks
        along ``theta``, radians in the map frame; unless that is said, where it was believed to
        look, unless they contradict.

        Raises:
            UnknownRoomError: no such room.
        """
        pose = self._pose_at(room, theta)
        self._believe(pose, spread=0.15, turn_spread=0.15)
        self._confidence.told(room.lower(), self._odom)
        return self.position()

    def _pose_at(self, room: str, theta: float | None) -> Pose:
        spots = [self.floor.place(room), *self.planner.graph.before(room.lower())]
        believed = self.localizer.estimate.theta
        looks = [believed + turn for turn in LOOKS] if theta is None else [wrap(theta)]
        poses: list[Pose] = [(x, y, look) for look in looks for x, y in spots]
        return max(poses, key=lambda pose: self._favour(pose, poses[0]))

    def _favour(self, pose: Pose, first: Pose) -> float:
        """How well a pose fits what is heard; a little less the less it is expected."""
        turned = abs(pose[2] - first[2]) > TURNED
        moved = pose[:2] != first[:2]
        return self.localizer.fit(pose, self._ranges) - 0.2 * turned - 0.05 * moved

    @property
    def _heard(self) -> tuple[Floats, int, Floats, int]:
        here = self._percept
        return (here.ring, here.renewed, here.own, here.fresh)

    @_heard.setter
    def _heard(self, state: tuple[Floats, int, Floats, int]) -> None:
        self._percept = Percept(*state)

    @property
    def _ranges(self) -> Floats:
        """What sonars hear that are to be believed, metres from the ring, shape (24,)."""
        return self._percept.own

    @property
    def pose(self) -> Pose:
        """Where the robot is believed to be: metres and radians."""
        return self.localizer.estimate.pose

    def set_pose(self, pose: Pose) -> None:
        """Believe to be at a pose, as somebody said who sees the robot there."""
        self._believe(pose, spread=0.1, turn_spread=0.1)

    def freeze(self) -> dict[str, Any]:
        """The whole state between two drives: `thaw` goes on from it bit for bit."""
        return freeze(self)

    def thaw(self, state: dict[str, Any]) -> None:
        """Go on from what `freeze` gave; a drive under way is given up."""
        self.cancel()
        thaw(self, state)
        self._has_sensed = self._odom is not None

    def snapshot(self) -> dict[str, Any]:
        """What `restore` needs to go on, roughly: the estimate, not each particle."""
        here = self.localizer.estimate
        return {
            "map": self.floor.plan.name,
            "time": self.time,
            "pose": list(here.pose),
            "deviation": here.deviation,
            "heading_deviation": here.heading_deviation,
            "odom": list(self._odom) if self._odom else None,
            "hindrances": self.memory.snapshot(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a snapshot: odometry carries the estimate over the time in between.

        Raises:
            KeyError, TypeError, ValueError: it is none; nothing is changed then.
        """
        pose, odom = _pose_of(state["pose"]), state["odom"]
        spread, turn_spread = _number(state["deviation"]), _number(state["heading_deviation"])
        before = None if odom is None else _pose_of(odom)
        time, memory = _number(state["time"]), Memory()
        memory.restore(state["hindrances"])
        self._believe(pose, spread=max(0.1, spread), turn_spread=max(0.06, turn_spread))
        self._odom, self.time = before, time
        self.memory.restore(memory.snapshot())

    def _listen(self, sensors: Sensors) -> None:
        odom, here = self._odom or ORIGIN, self._percept
        self.surroundings.see(odom, here.sights, sensors.time)
        self.surroundings.hear(
            odom, here.ring, here.fresh | here.renewed, sensors.time, lit=here.lit
        )
        if (direction := bump_direction(sensors.bump)) is not None:
            self.surroundings.touch(odom, direction, sensors.time)

    def _locate(self, motion: Motion) -> None:
        """Let the localizer know how the robot moved, and what it senses of the map."""
        here, was_lost = self._percept, self.localizer.lost
        self.localizer.move(motion)
        mapped = here.fresh & ~self._strange()
        self.localizer.sense(here.own, mapped, still=motion.still(), striper=here.striper)
        if was_lost and not self.localizer.lost:
            self.strangers.forget()

    def _strange(self) -> int:
        """Which sonars hear strangers, as bits: they tell nothing of the map."""
        if self.localizer.lost or not self.strangers.around:
            return 0
        spaces = self.floor.open_around(*self.pose[:2], within=STRANGERS_WITHIN)
        return self.strangers.explained(self._ranges, self.pose, spaces)

    def _believe(self, pose: Pose, *, spread: float, turn_spread: float) -> None:
        """Believe to be elsewhere: whoever was met is not where that was on the map."""
        self.localizer.place(pose, spread=spread, turn_spread=turn_spread)
        self.strangers.forget()

    def _reckon(self, sensors: Sensors) -> Motion:
        now: Pose = (float(sensors.odom[0]), float(sensors.odom[1]), float(sensors.odom[2]))
        before, seconds = self._odom, abs(sensors.time - self.time)
        self._odom, self.time = now, sensors.time
        if before is None:
            return Motion(0.0, 0.0, 0.0)
        motion = motion_between(before, now)
        if plausible(motion, seconds):
            return motion
        self.localizer.widen(spread=UNSEEN_SPREAD, turn_spread=0.2)
        self.strangers.forget()
        return Motion(0.0, 0.0, 0.0)

    def _search(self) -> None:
        """While lost and standing, look for a pose that fits, in growing circles."""
        if not self.localizer.lost:
            self._searches = 0
        elif self._still_ticks and self._still_ticks % SEARCH_EVERY == 0:
            radius = SEARCH_RADII[min(self._searches, len(SEARCH_RADII) - 1)]
            self._searches += 1
            self.localizer.recover(self._ranges, radius=radius)

    def _learn(self) -> None:
        """Let the localizer know what the driver found out about where the robot is."""
        findings = self.driver.take_findings()
        if findings.pose is not None:
            self._believe(findings.pose, spread=FIX_SPREAD, turn_spread=FIX_TURN_SPREAD)
        if findings.look is not None and not self.localizer.lost:
            self.localizer.orient(findings.look.theta, spread=findings.look.doubt)
        if findings.doubt is not None and not self.localizer.lost:
            spread, turn_spread = findings.doubt
            self.localizer.widen(spread=spread, turn_spread=turn_spread)
        if findings.refuted:
            self.localizer.doubt()

    def _watch_doors(self) -> None:
        """Remember how doors stand that the robot passes."""
        here = self.localizer.estimate
        if self.localizer.lost or here.deviation > SURE_OF_DOORS:
            self._door_watch.forget()
            return
        for door, is_open in self._door_watch.look(here.pose, self._percept, self.time):
            if is_open:
                self.memory.opened(door)
            else:
                self.memory.glimpse(door, self.time)

    def _advice(self) -> float | None:
        """Where a robot that is lost on its way had best go, as far as belief says."""
        drive = self.driver.drive
        if drive is None or drive.done or not self.localizer.lost:
            return None
        return self.localizer.way_to(drive.goal)

    def _goal_mass(self) -> float:
        """How much of belief is at the goal of a robot that is near it; 1.0 on the way."""
        drive = self.driver.drive
        if drive is None or drive.done or math.dist(self.pose[:2], drive.goal) > AT_GOAL:
            return 1.0
        return self.mass_at(drive.goal)

    def _view(self, sensors: Sensors) -> View:
        odom, here = self._odom or ORIGIN, self._percept
        around = self.surroundings.picture(odom, within=ECHO_RANGE)
        return View(
            time=sensors.time,
            pose=self.localizer.estimate.pose,
            odom=odom,
            ranges=here.ring,
            fresh=here.fresh,
            renewed=here.renewed,
            blind=here.blind,
            bump=sensors.bump,
            echoes=around.spots,
            spreads=around.spreads,
            lost=self.localizer.lost,
            supposed=self.localizer.supposes,
            advice=self._advice(),
            goal_mass=self._goal_mass(),
            speed=sensors.speed,
            turn=sensors.turn_rate,
            sights=here.sights,
            close_ahead=_is_close_ahead(sensors),
        )


def _is_close_ahead(sensors: Sensors) -> bool:
    """Whether a panel is pressed, or a sonar that looks ahead reads next to nothing."""
    return bool(sensors.bump) or bool((sensors.sonar.take(_AHEAD) < CLOSE).any())


def _pose_of(values: Any) -> Pose:
    x, y, theta = (_number(value) for value in values)
    return (x, y, theta)


def _number(value: Any) -> float:
    """A finite number.

    Raises:
        TypeError, ValueError: it is none.
    """
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{number} is no finite number")
    return number
