"""The lines beneath the drawings."""

from __future__ import annotations

import math
from datetime import UTC, datetime

from navigate.messages import DriveProgress, Outlook, Position
from navigate.wording import in_words
from xavier_sim.messages import WorldView


def of_world(world: WorldView, position: Position) -> list[str]:
    """What really is: where, since when, how far off the belief is."""
    robot = world.robot
    off = math.dist((robot.x, robot.y), (position.x, position.y))
    where = robot.room or robot.space or "nowhere"
    return [
        f"really at ({robot.x:.2f}, {robot.y:.2f}) m, {where}; believed {off:.2f} m off that",
        f"{moment(robot.time)} · {robot.metres:.0f} m driven, {counted(robot.bumps, 'bump')}",
    ]


def of_navigator(outlook: Outlook) -> list[str]:
    """What is believed, and how the drive goes."""
    belief, position = outlook.belief, outlook.belief.position
    words = in_words(position, heading=False)
    first = words if position.lost or not position.heard else f"believed at {words}"
    return [first, f"entropy {belief.entropy:.1f} bit · {of_drive(outlook.drive)}"]


def of_drive(drive: DriveProgress | None) -> str:
    """How a drive goes, in a few words."""
    if drive is None:
        return "no drive under way"
    goal = drive.room or f"({drive.x:.0f}, {drive.y:.0f}) cm"
    left = "planning"
    if drive.metres_left is not None and drive.seconds_left is not None:
        left = f"{drive.metres_left:.1f} m, {drive.seconds_left:.0f} s left"
    recoveries = f", {counted(drive.recoveries, 'recovery')}" if drive.recoveries else ""
    return f"to {goal}: {left}{recoveries}"


def counted(number: int, what: str) -> str:
    """A number of things."""
    if number == 1:
        return f"1 {what}"
    return f"{number} {what[:-1]}ies" if what.endswith("y") else f"{number} {what}s"


def moment(time: float) -> str:
    """A time in seconds since the epoch as a date and a clock show it."""
    return datetime.fromtimestamp(time, UTC).strftime("%Y-%m-%d %H:%M:%S")
