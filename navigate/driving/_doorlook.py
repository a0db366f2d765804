"""A second look at a door that seems shut, or whose jambs were touched: along its wall.

A robot that stands half a metre along the corridor from where it believes to be looks at the wall
beside an open door, and one whose heading is off at its jamb. Either sees the opening as it turns,
and by that knows where it stands. Of a door in which somebody stands it sees the rest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from navigate.body import Pose, wrap
from navigate.driving._doorframe import DoorFrame
from navigate.driving._turning import turn_rate
from navigate.driving._view import Manoeuvre, View, Wheels
from navigate.driving._wallscan import Line, Opening, WallScan
from navigate.maps import Passage

ASIDE = math.radians(52.0)
"""How far the robot turns to either side; its laser sees half its view farther."""

SWEEP, SWEEP_SECONDS = 0.7, 6.0
"""Radians per second, and how long turning to one side may take."""

THERE = 0.05
"""Radians off at which the robot has turned as far as it meant to."""

FARTHEST = 1.1
"""Metres beside the place of a door up to which an opening is that door: less than half of what
two doors of an office are apart."""

LEAST_GAP = 0.15
"""Metres of a door through which light goes that show that it is not shut."""

AS_BELIEVED, TURNED_AS_BELIEVED = 0.1, math.radians(3.0)
"""Metres and radians off up to which a door, or the robot, is where it was believed to be."""


class DoorSeen(NamedTuple):
    """An open door: the ``pose`` of the robot on the map by which it stands where it does.

    ``off`` are metres along the wall, to the left, and ``turned`` radians, from where the door was
    looked for.
    """

    pose: Pose
    off: float
    turned: float

    @property
    def is_as_believed(self) -> bool:
        """Whether the door is where it was looked for."""
        return abs(self.off) < AS_BELIEVED and abs(self.turned) < TURNED_AS_BELIEVED

    def is_at(self, pose: Pose) -> bool:
        """Whether the door says that the robot is at ``pose``, on the map."""
        near = math.dist(self.pose[:2], pose[:2]) < AS_BELIEVED
        return near and abs(wrap(self.pose[2] - pose[2])) < TURNED_AS_BELIEVED


class SecondLook(NamedTuple):
    """What a look along the wall showed: the door, if it is open, or that somebody is in it."""

    view: View
    door: DoorSeen | None
    obstructed: bool


def look_along(view: View, frame: DoorFrame) -> Manoeuvre[SecondLook]:
    """Turn to both sides before a door, and say whether it is seen open there, and from where."""
    ahead, left, _ = frame.locate(view.odom)
    scan = WallScan(view.odom, Line(-ahead, frame.heading))
    for aside in (ASIDE, -ASIDE):
        until = view.time + SWEEP_SECONDS
        while view.time < until:
            for laser, sight in view.sights:
                scan.add(view.odom, laser, sight.ranges)
            error = wrap(frame.heading + aside - view.odom[2])
            if abs(error) < THERE:
                break
            view = yield Wheels(0.0, turn_rate(error, top=SWEEP))
    seen = scan.look(frame.door.width, expected=-left, within=FARTHEST)
    if seen.opening is None:
        return SecondLook(view, None, seen.gap >= LEAST_GAP)
    return SecondLook(view, _seen(frame, view.odom, seen.opening), obstructed=False)


def _seen(frame: DoorFrame, odom: Pose, opening: Opening) -> DoorSeen:
    off = opening.left + frame.locate(odom)[1]
    lean = wrap(opening.heading - frame.heading)
    return DoorSeen(pose_before(frame.door, frame.sign, opening, odom), off, lean)


def pose_before(door: Passage, sign: float, opening: Opening, odom: Pose) -> Pose:
    """Where a robot is on the map that has an opening before it, if that is ``door``.

    Args:
        door: on the map.
        sign: 1.0 to pass it from its first space to its second, -1.0 the other way.
        opening: as it is seen.
        odom: of the robot.
    """
    ahead_x, ahead_y = door.normal[0] * sign, door.normal[1] * sign
    x = door.centre[0] - opening.away * ahead_x + opening.left * ahead_y
    y = door.centre[1] - opening.away * ahead_y - opening.left * ahead_x
    return (x, y, wrap(math.atan2(ahead_y, ahead_x) + odom[2] - opening.heading))
