"""What the navigator needs of whatever knows where the robot is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from navigate.body import Motion, Pose
from navigate.freezing import Freezable
from navigate.maps import Floats, Point

HEADINGS = 4
"""Headings that a belief tells apart: east, north, west and south."""

COARSE = 1.0
"""Metres along a side of the cells in which a belief is told."""


NO_BEAMS: Floats = np.empty(0)
"""What a robot without a light striper sees with it."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """A believed pose in the map frame, with standard deviations in metres and radians.

    ``agreement`` is the running share of sonar readings that fit the map there, 0 to 1.
    """

    x: float
    y: float
    theta: float
    deviation: float
    heading_deviation: float
    agreement: float

    @property
    def pose(self) -> Pose:
        """x, y, theta."""
        return (self.x, self.y, self.theta)


@dataclass(frozen=True, slots=True)
class Belief:
    """A distribution over cells of one metre by four headings, the most probable first.

    ``poses`` has shape (n, 3): the middles of what is believed in each cell, metres and radians;
    ``shares`` has shape (n,) and sums up to 1. Every localizer tells its belief so, whatever it
    computes with, so that the entropies of two of them can be compared.
    """

    poses: Floats
    shares: Floats

    @property
    def entropy(self) -> float:
        """Bits; 0 for a robot that is sure of its cell."""
        sound = self.shares[self.shares > 0.0]
        return max(0.0, float(-(sound * np.log2(sound)).sum()))


def in_cells(x: Floats, y: Floats, theta: Floats, shares: Floats) -> Belief:
    """The belief of weighted poses, all of shape (n,); ``shares`` need not sum up to 1."""
    quarter = np.rint(theta * (HEADINGS / (2.0 * math.pi))).astype(np.int64) % HEADINGS
    cells = np.column_stack([np.floor(x / COARSE), np.floor(y / COARSE), quarter])
    _, which = np.unique(cells.astype(np.int64), axis=0, return_inverse=True)
    mass = _sums(which, shares)
    middles = [_sums(which, shares * value) / mass for value in (x, y)]
    look = np.arctan2(_sums(which, shares * np.sin(theta)), _sums(which, shares * np.cos(theta)))
    order = np.argsort(-mass, kind="stable")
    return Belief(np.column_stack([*middles, look])[order], mass[order] / mass.sum())


def _sums(which: NDArray[np.intp], values: Floats) -> Floats:
    return np.asarray(np.bincount(which, weights=values))


class Localizer(Freezable, Protocol):
    """Knows where the robot is, by what it is told of motions and readings.

    Deterministic: two that are made with the same floor and seed and are told the same say the
    same. Positions are in metres in the map frame, angles in radians. ``STATE`` names the
    attributes that hold all that it was told, so that it can be kept and gone on with exactly.
    """

    @property
    def estimate(self) -> Estimate:
        """What is believed now."""

    @property
    def lost(self) -> bool:
        """Whether the estimate is not to be driven on."""

    @property
    def supposes(self) -> bool:
        """Whether a robot that is lost had best go on as if the estimate were right.

        What is heard fits it then, but fits other poses as well; on the way they come apart.
        """

    def doubt(self) -> None:
        """Take in that a robot that is lost cannot well be at the estimate: it found no way on."""

    def belief(self) -> Belief:
        """The whole distribution, as it is published."""

    def place(self, pose: Pose, *, spread: float = 0.05, turn_spread: float = 0.03) -> None:
        """Believe to be at ``pose``, give or take: standard deviations in metres and radians."""

    def orient(self, theta: float, *, spread: float) -> None:
        """Take in which way the robot looks, as something shows that stands beside it.

        ``theta`` and its standard deviation are in radians, in the map frame.
        """

    def widen(self, *, spread: float, turn_spread: float) -> None:
        """Doubt the position more: somebody may have moved the robot unseen."""

    def move(self, motion: Motion) -> None:
        """Take in a motion as odometry reports it."""

    def sense(self, ranges: Floats, fresh: int, *, still: bool, striper: Floats = NO_BEAMS) -> None:
        """Take in the fresh ones of 24 sonar ``ranges``, metres from the ring, inf for no echo.

        ``striper`` are the beams of a light striper, metres, inf where nothing is seen; empty on
        a robot without one.
        """

    def notice(self, spots: Sequence[Point], *, within: float, sure: float) -> None:
        """Take in a sight that is to be had within some metres of one of ``spots``.

        It is right with probability ``sure``: elsewhere the belief shrinks by the odds of that.
        """

    def mass_near(self, x: float, y: float, *, within: float) -> float:
        """The share of belief that lies ``within`` metres of a point, 0 to 1."""

    def fit(self, pose: Pose, ranges: Floats) -> float:
        """The share of a ring of readings that a robot at ``pose`` would have, 0 to 1."""

    def recover(self, ranges: Floats, *, radius: float) -> None:
        """Look for the robot within ``radius`` metres of the estimate, by a ring of readings.

        That may take some ticks. A pose that fits well enough to go on with is taken in, and the
        robot is no longer `lost`.
        """

    def way_to(self, goal: Point) -> float | None:
        """Which way to go to a point in metres while lost, radians to the left of ahead.

        None where belief says nothing about that, or nothing yet.
        """
