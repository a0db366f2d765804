"""What the navigator knows of the robot's body, its sonars and its odometry."""

from navigate.body._odometry import Motion, Pose, motion_between, moved, plausible
from navigate.body._sonarring import (
    BEARINGS,
    CONE_HALF,
    NEAREST,
    RING_RADIUS,
    ROBOT_RADIUS,
    bump_direction,
    fault_of,
    fresh_sonars,
    heard_ranges,
    wrap,
)

__all__ = [
    "BEARINGS",
    "CONE_HALF",
    "NEAREST",
    "RING_RADIUS",
    "ROBOT_RADIUS",
    "Motion",
    "Pose",
    "bump_direction",
    "fault_of",
    "fresh_sonars",
    "heard_ranges",
    "motion_between",
    "moved",
    "plausible",
    "wrap",
]
