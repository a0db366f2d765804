"""What the navigator tells of itself: its belief, and how a drive goes."""

from __future__ import annotations

import math

import numpy as np

from navigate.body import heard_ranges
from navigate.driving import Drive
from navigate.maps import CENTIMETRES, Floats, Point
from navigate.messages import MOST_CELLS, BeliefCell, BeliefState, DriveProgress, Outlook
from navigate.navigator import Navigator
from navigate.routes import remaining, seconds_left
from xavier_sim.messages import LIDAR_VIEW, STRIPER_AHEAD, STRIPER_VIEW, Sensors


def belief_state(navigator: Navigator, goal: Point | None) -> BeliefState:
    """The belief, with its share at ``goal`` (metres) if there is one."""
    belief = navigator.localizer.belief()
    return BeliefState(
        position=navigator.position(),
        entropy=round(belief.entropy, 4),
        lost=navigator.localizer.lost,
        goal_mass=None if goal is None else navigator.mass_at(goal),
        cells=_cells(belief.poses[:MOST_CELLS], belief.shares[:MOST_CELLS]),
    )


def drive_progress(navigator: Navigator, drive: Drive, task: str) -> DriveProgress:
    """How the drive of a task goes."""
    here = navigator.localizer.estimate
    at, steps = (here.x, here.y), drive.steps
    x, y = drive.goal
    return DriveProgress(
        task=task,
        x=round(x * CENTIMETRES, 1),
        y=round(y * CENTIMETRES, 1),
        room=navigator.floor.room_near(x, y),
        metres_left=round(remaining(at, steps), 2) if steps else None,
        seconds_left=round(seconds_left(at, steps), 1) if steps else None,
        metres=round(drive.metres, 2),
        seconds=round(navigator.time - drive.began, 2),
        recoveries=drive.recoveries,
        goal_mass=navigator.mass_at(drive.goal),
        time=navigator.time,
        faults=navigator.perception.faults,
        lost=navigator.localizer.lost,
    )


def outlook(
    navigator: Navigator, sensors: Sensors | None, drive: Drive | None, task: str
) -> Outlook:
    """All that is seen, believed and wanted, with the latest ``sensors`` and a task's drive."""
    hindrances = navigator.memory.believed(navigator.time)
    return Outlook(
        belief=belief_state(navigator, drive.goal if drive else None),
        sonar=_ranges(sensors) if sensors else [],
        seen=_seen(sensors) if sensors else [],
        bump=sensors.bump if sensors else 0,
        drive=drive_progress(navigator, drive, task) if drive else None,
        way=_way(drive) if drive else [],
        shut=sorted(hindrances.doors),
        blocked=list(hindrances.points),
        faults=navigator.perception.faults,
    )


def _way(drive: Drive) -> list[Point]:
    return [(round(step.to[0], 3), round(step.to[1], 3)) for step in drive.steps]


def _ranges(sensors: Sensors) -> list[float | None]:
    ranges = heard_ranges(sensors).round(3).tolist()
    return [reading if math.isfinite(reading) else None for reading in ranges]


def _seen(sensors: Sensors) -> list[Point]:
    """The points that striper and lidar see, metres ahead and left."""
    points: list[Point] = []
    for ranges, view, ahead in (
        (sensors.striper, STRIPER_VIEW, STRIPER_AHEAD),
        (sensors.lidar, LIDAR_VIEW, 0.0),
    ):
        hit = np.isfinite(ranges)
        turns, far = np.linspace(-view / 2, view / 2, len(ranges))[hit], ranges[hit]
        spots = np.column_stack([ahead + far * np.cos(turns), far * np.sin(turns)])
        points += [(x, y) for x, y in spots.round(3).tolist()]
    return points


def _cells(poses: Floats, shares: Floats) -> tuple[BeliefCell, ...]:
    rows = zip(poses.round(3).tolist(), shares.round(5).tolist(), strict=True)
    return tuple(BeliefCell(x=x, y=y, theta=look, mass=mass) for (x, y, look), mass in rows)
