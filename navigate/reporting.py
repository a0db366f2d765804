"""What the navigator tells of itself: its belief, and how a drive goes."""

from __future__ import annotations

from navigate.driving import Drive
from navigate.maps import CENTIMETRES, Floats, Point
from navigate.messages import MOST_CELLS, BeliefCell, BeliefState, DriveProgress
from navigate.navigator import Navigator
from navigate.routes import remaining, seconds_left


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
        recoveries=len(drive.troubles),
        goal_mass=navigator.mass_at(drive.goal),
        time=navigator.time,
    )


def _cells(poses: Floats, shares: Floats) -> tuple[BeliefCell, ...]:
    rows = zip(poses.round(3).tolist(), shares.round(5).tolist(), strict=True)
    return tuple(BeliefCell(x=x, y=y, theta=look, mass=mass) for (x, y, look), mass in rows)
