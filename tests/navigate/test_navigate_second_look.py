"""A door that seems shut is looked at along the wall, and tells a robot off course where it is."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from navigate_loop import Loop

from navigate.body import LIDAR, STRIPER, Sight, wrap
from navigate.driving import DoorLog, View
from navigate.driving._doorframe import DoorFrame
from navigate.driving._doorlook import look_along
from navigate.driving._doorpass import pass_door
from navigate.driving._safety import GENTLE
from navigate.driving._view import BumpedInDoor, DoorObstructed, DoorShut, OffCourse
from navigate.driving._wallscan import Line, WallScan
from navigate.maps import Floor, load_plan
from navigate.messages import NavigationFailure
from xavier_sim.crowd._person import Person

DOOR = Floor(load_plan()).doors["d-5303"]
FACING = math.atan2(DOOR.normal[1], DOOR.normal[0])
BEFORE = 1.0
SILENT = np.full(24, np.inf)
WALLED = np.full(24, 0.7)


def wall_ranges(ahead, left, turned, laser, openings, *, blocked=None):
    """What a laser reads before an endless wall with openings, (right, left) metres to the left.

    ``blocked`` is a stretch of the wall before which somebody stands half a metre off.
    """
    looks = turned + laser.bearings
    x, y = ahead + laser.ahead * math.cos(turned), left + laser.ahead * math.sin(turned)
    cosine = np.cos(looks)
    ranges = np.where(cosine > 1e-3, -x / cosine.clip(1e-3), np.inf)
    crossing = y + np.where(np.isfinite(ranges), ranges, 0.0) * np.sin(looks)
    for right, far in openings:
        ranges = np.where((right < crossing) & (crossing < far), np.inf, ranges)
    if blocked is not None:
        ranges = np.where((blocked[0] < crossing) & (crossing < blocked[1]), 0.4, ranges)
    return np.where(ranges < laser.farthest, ranges, np.inf)


def scan(openings, *, at=(-BEFORE, 0.0, 0.0), expected=0.0, laser=STRIPER, blocked=None):
    """What a turn by an eighth to either side shows; ``expected`` is where the robot looks."""
    odom = (3.0, 4.0, expected)
    gathered = WallScan(odom, Line(-at[0], expected))
    for aside in np.arange(-0.9, 0.91, 0.06):
        ranges = wall_ranges(at[0], at[1], at[2] + aside, laser, openings, blocked=blocked)
        gathered.add((*odom[:2], expected + float(aside)), laser, ranges)
    return gathered.look(0.9, expected=0.0, within=1.1)


@pytest.mark.parametrize("laser", [STRIPER, LIDAR])
@pytest.mark.parametrize("middle", [-0.8, -0.35, 0.0, 0.6])
def test_an_opening_is_seen_where_it_is(middle, laser):
    seen = scan([(middle - 0.45, middle + 0.45)], laser=laser, expected=0.7).opening
    assert (seen.away, seen.left) == pytest.approx((BEFORE, middle), abs=0.04)
    assert seen.heading == pytest.approx(0.7, abs=0.01)


@pytest.mark.parametrize("off", [-0.25, 0.1, 0.25])
def test_a_wall_that_leans_is_seen_so(off):
    seen = scan([(-0.45, 0.45)], at=(-BEFORE, 0.0, off)).opening
    assert seen.heading == pytest.approx(-off, abs=0.02)
    assert (seen.away, seen.left) == pytest.approx((BEFORE, 0.0), abs=0.04)


@pytest.mark.parametrize(
    "openings",
    [
        [],
        [(0.4, 2.9)],
        [(-0.2, 0.2)],
        [(1.2, 2.1)],
        [(-0.9, 0.9)],
    ],
    ids=["shut", "mouth of a corridor", "narrow", "another door", "wide"],
)
def test_what_is_no_such_opening_is_not_taken_for_one(openings):
    assert scan(openings).opening is None


def test_of_a_door_in_which_somebody_stands_the_rest_is_seen():
    assert scan([(-0.45, 0.45)], blocked=(-0.2, 0.6)) == (None, pytest.approx(0.25, abs=0.06))
    assert scan([(0.5, 1.4)]).gap == scan([]).gap == 0.0
    assert scan([(-0.45, 0.45)]).gap == pytest.approx(0.9, abs=0.11)


def test_without_a_wall_nothing_is_seen():
    assert scan([(-5.0, 5.0)]) == (None, 0.0)
    nothing = WallScan((0.0, 0.0, 0.0), Line(1.0, 0.0))
    assert nothing.look(0.9, expected=0.0, within=1.0) == (None, 0.0)


def test_the_nearer_of_two_is_told():
    seen = scan([(-1.35, -0.45), (0.3, 1.2)]).opening
    assert seen.left == pytest.approx(0.75, abs=0.04)


class Robot:
    """A robot that stands before a wall, and believes to stand on the axis of a door in it.

    Args:
        openings: in the wall, metres to the left of where the robot is.
        turned: radians by which it believes to look farther left than it does.
    """

    def __init__(self, openings, *, turned=0.0, blocked=None):
        self.openings, self.off, self.blocked = openings, turned, blocked
        self.time, self.turned = 0.0, -turned
        self.turns = list[float]()

    @property
    def true_pose(self):
        return (*self._at, wrap(FACING + self.turned))

    @property
    def _at(self):
        (nx, ny), (x, y) = DOOR.normal, DOOR.centre
        return (x - BEFORE * nx, y - BEFORE * ny)

    def run(self, course):
        """Do what a manoeuvre says until it sets out to drive, and what it returns before that."""
        try:
            wheels = next(course)
            while wheels.speed <= 0.0:
                self.time += 0.1
                self.turned += 0.1 * wheels.turn
                self.turns.append(self.turned)
                wheels = course.send(self.view())
        except StopIteration as end:
            return end.value
        return None

    def view(self):
        odom = (0.0, 0.0, self.turned)
        ranges = wall_ranges(
            -BEFORE, 0.0, self.turned, STRIPER, self.openings, blocked=self.blocked
        )
        return View(
            time=self.time,
            pose=(*self._at, FACING + self.turned + self.off),
            odom=odom,
            ranges=WALLED,
            fresh=0xFFFFFF,
            bump=0,
            echoes=np.zeros((0, 2)),
            sights=((STRIPER, Sight(ranges, np.zeros((31, 2)), SILENT)),),
        )


def test_a_robot_off_course_is_told_its_pose_by_the_door():
    robot = Robot([(0.15, 1.05)], turned=0.1)
    seen = robot.run(look_along(robot.view(), DoorFrame(DOOR, 1.0, robot.view()))).door
    beside = 0.6
    (nx, ny), (x, y) = DOOR.normal, DOOR.centre
    assert not seen.is_as_believed
    assert seen.pose[:2] == pytest.approx(
        (x - BEFORE * nx + beside * ny, y - BEFORE * ny - beside * nx), abs=0.05
    )
    assert wrap(seen.pose[2] - robot.true_pose[2]) == pytest.approx(0.0, abs=0.02)
    assert abs(seen.off) > 0.4
    assert seen.turned == pytest.approx(0.1, abs=0.02)


def test_light_through_a_door_counts_for_more_than_an_echo_from_its_jambs():
    robot = Robot([(-0.45, 0.45)])
    robot.run(pass_door(robot.view(), DOOR, 1.0, DoorLog()))
    assert 4.0 < robot.time < 14.0
    assert abs(robot.turned) < 0.05


def test_an_open_door_beside_the_place_ends_the_wait():
    robot = Robot([(-1.1, -0.2)])
    with pytest.raises(OffCourse, match=r"d-5303 open 0\.6\d m beside and turned by 0 deg"):
        robot.run(pass_door(robot.view(), DOOR, 1.0, DoorLog()))
    assert robot.time < 14.0


def test_a_shut_door_is_looked_at_again_and_stays_shut():
    robot = Robot([])
    with pytest.raises(DoorShut):
        robot.run(pass_door(robot.view(), DOOR, 1.0, DoorLog()))
    assert 40.0 < robot.time < 50.0
    to_the_left = [turned > 0.8 for turned in robot.turns]
    assert sum(now and not before for before, now in pairwise(to_the_left)) == 2
    assert min(robot.turns) < -0.8


def test_somebody_in_an_open_door_is_waited_for_a_while():
    robot = Robot([(-0.45, 0.45)], blocked=(-0.3, 0.3))
    with pytest.raises(DoorObstructed, match=r"stood in door d-5303 for 1[5-9] s") as end:
        robot.run(pass_door(robot.view(), DOOR, 1.0, DoorLog()))
    assert end.value.at == DOOR.centre


def before_door(loop, *, along, turned=0.0):
    """Put the robot before a door, beside where it is told to be."""
    (nx, ny), (x, y) = DOOR.normal, DOOR.centre
    side = 1.05 if loop.navigator.floor.space_at(x + nx, y + ny).name == "corridor-53" else -1.05
    x, y = x + side * nx, y + side * ny
    heading = math.atan2(nx, -ny)
    loop.world.place_robot(x - along * ny, y + along * nx, heading)
    loop.sensors = loop.robot.sensors()
    loop.navigator.step(loop.sensors)
    loop.navigator.set_pose((x, y, heading + turned))


@pytest.mark.parametrize("along", [-0.6, 0.7])
def test_off_course_before_an_open_door_the_robot_puts_itself_right_and_goes_in(along):
    loop = Loop(seed=3)
    before_door(loop, along=along)
    drive = loop.drive("r-5303", most=600)
    assert drive.failure is None
    assert [type(met) for met in drive.troubles] == [OffCourse]
    assert loop.off("r-5303") < 0.2
    assert loop.astray() < 0.15
    report = loop.navigator.report(drive)
    assert (report.recoveries, report.door) == (1, None)
    assert loop.navigator.doors.doors["d-5303"].stuck == 0


def test_off_course_before_a_shut_door_it_is_shut_all_the_same():
    loop = Loop(seed=3)
    before_door(loop, along=0.5)
    loop.world.set_door("r-5303", is_open=False)
    drive = loop.drive("r-5303", most=600)
    assert drive.failure.reason is NavigationFailure.DOOR_BLOCKED
    assert [type(met) for met in drive.troubles] == [DoorShut]


def askew_in_door(loop, *, aside, turned):
    """Put the robot into the door, near a jamb, and let it believe to look elsewhere."""
    (nx, ny), (x, y) = DOOR.normal, DOOR.centre
    side = -1.0 if loop.navigator.floor.space_at(x + nx, y + ny).name == "r-5303" else 1.0
    x, y = x + side * (0.3 * nx - aside * ny), y + side * (0.3 * ny + aside * nx)
    heading = math.atan2(-side * ny, -side * nx)
    loop.world.place_robot(x, y, heading + turned / 2)
    loop.sensors = loop.robot.sensors()
    loop.navigator.step(loop.sensors)
    loop.navigator.localizer.place((x, y, heading - turned / 2))


@pytest.mark.parametrize(("aside", "turned"), [(0.15, -12.0), (-0.15, 12.0), (-0.2, -12.0)])
def test_after_a_touch_in_a_door_the_robot_backs_out_and_looks_where_it_is(aside, turned):
    loop = Loop(seed=3)
    askew_in_door(loop, aside=aside, turned=math.radians(turned))
    touched, known = list[float](), list[float]()

    def look():
        drive = loop.navigator.driver.drive
        if drive.troubles:
            off = abs(wrap(loop.navigator.pose[2] - loop.world.pose[2]))
            (known if drive.steps else touched).append(math.degrees(off))

    drive = loop.drive("r-5303", most=900, each=look)
    assert drive.failure is None
    assert [type(met) for met in drive.troubles] == [BumpedInDoor]
    assert touched[0] > 5.0
    assert known[0] < 3.0
    assert loop.off("r-5303") < 0.25


def in_doorway(loop, *, pause=0.0, way=()):
    """Put somebody into the door, who wants to go some way once ``pause`` seconds are over."""
    (x, y), crowd = DOOR.centre, loop.world._crowd
    crowd.people[0] = person = Person(x, y, speed=1.2, lane=0.5, pause=pause, way=list(way))
    crowd._list()
    return person


def test_room_is_made_for_somebody_in_the_door_until_they_go():
    loop = Loop(seed=3, people=1)
    before_door(loop, along=0.0)
    x, y = DOOR.centre[0] + 1.2 * DOOR.normal[0], DOOR.centre[1]
    person = in_doorway(loop, pause=25.0, way=[(x, y), (x, y + 8.0)])
    away = list[float]()

    def look():
        if loop.navigator.driver.drive.troubles:
            away.append(math.dist(loop.world.pose[:2], DOOR.centre))

    drive = loop.drive("r-5303", most=900, each=look)
    assert drive.failure is None
    assert [type(met) for met in drive.troubles] == [DoorObstructed]
    assert max(away) > 1.4
    assert math.dist((person.x, person.y), DOOR.centre) > 1.0
    assert loop.off("r-5303") < 0.2
    assert loop.world.truth().people_hit == 0


def test_somebody_who_stays_in_the_door_is_named_as_what_blocks_it():
    loop = Loop(seed=3, people=1)
    before_door(loop, along=0.0)
    in_doorway(loop, pause=1000.0)
    drive = loop.drive("r-5303", most=4000)
    assert drive.failure.reason is NavigationFailure.DOOR_BLOCKED
    assert "somebody stood in door d-5303" in drive.failure.text
    assert {type(met) for met in drive.troubles} == {DoorObstructed}
    assert loop.navigator.report(drive).door == "r-5303"
    assert loop.world.truth().people_hit == 0


def test_whoever_stands_right_beside_the_way_to_a_door_is_no_more_than_brushed():
    beside = np.full(24, 3.0)
    beside[3] = 0.2
    robot = Robot([(-0.45, 0.45)])
    view = replace(robot.view(), ranges=np.full(24, 3.0), fresh=0xFFFFFF)
    course = pass_door(view, DOOR, 1.0, DoorLog())
    wheels = next(course)
    while wheels.speed <= 0.0:
        view = replace(view, time=view.time + 0.1)
        wheels = course.send(view)
    assert wheels.speed > 0.2
    assert course.send(replace(view, ranges=beside)).speed == GENTLE
