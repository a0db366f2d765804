"""What is kept of a drive while it lasts, so that it can be explained should it fail."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from xavier_sim.body import wrap
from xavier_sim.profile import TICK
from xavier_sim.soak._contract import Pose
from xavier_sim.soak._examiner import Examiner, Point, Upright, degrees
from xavier_sim.soak._postmortem import ASTRAY_FROM, LAST_WHILE, LOST, PostMortem, Stray

LEAP = 1.5
"""Metres by which neither a robot nor an honest belief moves between two looks."""


class Evidence:
    """Since when a robot has been astray or in company, and which doors moved when.

    Args:
        examiner: of the floor.
        look_seconds: between two looks.
    """

    def __init__(self, examiner: Examiner, look_seconds: float) -> None:
        self._examiner, self._look_seconds = examiner, look_seconds
        self._astray, self._in_company = 0, 0
        self._before: tuple[Point, Point] | None = None
        self._stray: Stray | None = None
        self._strayed_in: str | None = None
        self._is_open: Mapping[str, bool] = {}
        self._moved = dict[str, int]()

    def doors_moved(self, tick: int, open_doors: Mapping[str, bool]) -> None:
        """Note which doors stand otherwise than before, and how they stand now."""
        before, self._is_open = self._is_open, dict(open_doors)
        for door, is_open in self._is_open.items():
            if before.get(door, is_open) != is_open:
                self._moved[door] = tick

    def look(self, at: Point, believed: Point, around: Sequence[Upright]) -> None:
        """Note at a look whether belief is far from the truth, and whether anybody is near."""
        is_astray = math.dist(at, believed) > ASTRAY_FROM
        if is_astray and not self._astray:
            self._stray, self._strayed_in = self._parting(at, believed), self._examiner.space(at)
        self._astray = self._astray + 1 if is_astray else 0
        self._before = at, believed
        near = bool(around) and bool(self._examiner.near(at, around, self._is_open))
        self._in_company = self._in_company + 1 if near else 0

    def examine(
        self,
        pose: Pose,
        believed: Pose,
        around: Sequence[Upright],
        *,
        reason: str | None,
        ends: Sequence[str | None],
        blamed: str | None,
        tick: int,
    ) -> PostMortem:
        """The facts about a drive that failed.

        Args:
            pose: of the robot.
            believed: where its navigator believes it to be.
            around: who and what stands about.
            reason: that was given.
            ends: the spaces between which it drove.
            blamed: the room whose door is said to have ended it.
            tick: of the end.
        """
        examiner = self._examiner
        (x, y, theta), (believed_x, believed_y, believed_theta) = pose, believed
        space = examiner.space((x, y))
        along, across = examiner.along_and_across(space, (x - believed_x, y - believed_y))
        lately = tick - LAST_WHILE / TICK
        moved = [door for door, at in self._moved.items() if at > lately]
        off = math.dist((x, y), (believed_x, believed_y)) > ASTRAY_FROM
        astray = self._astray if off else 0
        company = examiner.company(pose, around, self._is_open)
        return PostMortem(
            x=round(x, 3),
            y=round(y, 3),
            heading=degrees(theta),
            space=space,
            believed_x=round(believed_x, 3),
            believed_y=round(believed_y, 3),
            believed_heading=degrees(believed_theta),
            believed_space=examiner.space((believed_x, believed_y)),
            along=round(along, 3),
            across=round(across, 3),
            turned=degrees(wrap(theta - believed_theta)),
            astray=self._seconds(astray),
            stray=self._stray if astray else None,
            strayed_in=self._strayed_in if astray else None,
            doors=examiner.doors((*ends, blamed), self._is_open, moved),
            blamed=blamed,
            company=company,
            in_company=self._seconds(self._in_company if company else 0),
            lost=reason == LOST,
        )

    def _parting(self, at: Point, believed: Point) -> Stray:
        """How belief and truth parted since the last look."""
        if self._before is None:
            return Stray.BEFORE
        was_at, was_believed = self._before
        if math.dist(was_at, at) > LEAP:
            return Stray.CARRIED
        return Stray.JUMPED if math.dist(was_believed, believed) > LEAP else Stray.DRIFTED

    def _seconds(self, looks: int) -> float:
        return round(looks * self._look_seconds, 1)
