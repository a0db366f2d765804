"""What the navigator knows of the robot's body, its sonars and its odometry."""

from navigate.body._localgrid import LocalGrid
from navigate.body._odometry import Motion, Pose, motion_between, moved, plausible
from navigate.body._reports import MotionReports, Moved, Turned, find_axis
from navigate.body._sonarring import (
    BEARINGS,
    CONE_HALF,
    NEAREST,
    PITCH,
    RING_RADIUS,
    ROBOT_RADIUS,
    bump_direction,
    fault_of,
    fresh_sonars,
    heard_ranges,
    wrap,
)
from navigate.body._virtual import (
    AHEAD,
    BEHIND,
    BESIDE,
    FRONT_REACH,
    STRIP,
    Front,
    Side,
    look_aside,
    look_front,
    side_of_share,
)

__all__ = [
    "AHEAD",
    "BEARINGS",
    "BEHIND",
    "BESIDE",
    "CONE_HALF",
    "FRONT_REACH",
    "NEAREST",
    "PITCH",
    "RING_RADIUS",
    "ROBOT_RADIUS",
    "STRIP",
    "Front",
    "LocalGrid",
    "Motion",
    "MotionReports",
    "Moved",
    "Pose",
    "Side",
    "Turned",
    "bump_direction",
    "fault_of",
    "find_axis",
    "fresh_sonars",
    "heard_ranges",
    "look_aside",
    "look_front",
    "motion_between",
    "moved",
    "plausible",
    "side_of_share",
    "wrap",
]
