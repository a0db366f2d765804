"""The belief over the states of the Markov model, and how reports change it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from navigate.body import Front, Moved, Pose, Side, Turned, wrap
from navigate.maps import Floats, Floor, Point
from navigate.position._features import Features
from navigate.position._localizer import Belief
from navigate.position._markov import TURNS, Indices, MarkovModel
from navigate.position._topology import build_topology

ANYWHERE = 0.002
"""What every sensor report leaves for the chance to be anywhere: never completely lost."""

LOOKING = 0.3
"""Cosine of the angle to a heading from which a state looks about along it."""

BEYOND_WALL = 0.1
"""How much less a cell of another room or corridor is meant than one of the same, as near."""

FAINT = 1e-6
"""Mass of a state below which it is not told."""

_LOOKS: Floats = np.array([wrap(quarter * math.pi / 2) for quarter in range(TURNS)])


class MarkovBelief:
    """Where the robot may be: ``chances`` of the model's states, which sum up to 1.

    Starts knowing nothing: even over all states.
    """

    STATE: ClassVar[tuple[str, ...]] = ("chances",)

    def __init__(self, model: MarkovModel, features: Features) -> None:
        self.model, self._features = model, features
        self._spaces = np.array(model.locations.spaces)
        self.chances: Floats = np.full(model.size, 1.0 / model.size)

    @classmethod
    def of_floor(cls, floor: Floor) -> MarkovBelief:
        """The belief of a robot that is put down somewhere on ``floor``."""
        model = MarkovModel(build_topology(floor))
        return cls(model, Features(floor, model.locations.at))

    def forget(self, share: float = 1.0) -> None:
        """Take the robot to be anywhere, with a chance of ``share``."""
        self.chances = (1.0 - share) * self.chances + share / self.model.size

    def know(
        self, pose: Pose, *, spread: float = 0.5, turn_spread: float = 0.2, share: float = 1.0
    ) -> None:
        """Believe to be at ``pose``, give or take: standard deviations in metres and radians.

        With a ``share`` below 1 what was believed before keeps the rest.
        """
        at = self.model.locations.at
        doubt = max(spread, 0.4)
        away = np.hypot(at[:, 0] - pose[0], at[:, 1] - pose[1])
        near = np.exp(-0.5 * ((away - away.min()) / doubt) ** 2)
        near *= np.where(self._spaces == self._spaces[away.argmin()], 1.0, BEYOND_WALL)
        turns = np.array([wrap(pose[2] - look) for look in _LOOKS.tolist()])
        facing = np.exp(-0.5 * (turns / max(turn_spread, 0.35)) ** 2)
        there = np.outer(facing + 1e-9, near).ravel()
        self._set((1.0 - share) * self.chances + share * there / there.sum())

    def report(self, report: Moved | Turned) -> None:
        """Take in a motion report."""
        if isinstance(report, Moved):
            self._set(self.model.moved(self.chances, relative=report.relative))
        else:
            self.chances = self.model.turned(self.chances, quarters=report.quarters)

    def see(self, front: Front | None, left: Side | None, right: Side | None) -> None:
        """Take in a sensor report; None for what is not known."""
        likelihood = self._features.likelihood(front, left, right)
        if likelihood is not None:
            self._set(self.chances * likelihood)
            self.forget(ANYWHERE)

    def notice(self, spots: Sequence[Point], *, within: float, sure: float) -> None:
        """Take in a sight, right with probability ``sure``, to be had near one of ``spots``."""
        at, near = self.model.locations.at, np.zeros(len(self.model.locations), dtype=np.bool_)
        for x, y in spots:
            near |= np.hypot(at[:, 0] - x, at[:, 1] - y) <= within
        self._set(self.chances * np.tile(np.where(near, sure, 1.0 - sure), TURNS))

    def favour(self, pose: Pose, *, within: float, sure: float) -> None:
        """Take in that ``pose`` is right, give or take some metres, with probability ``sure``."""
        about = self._about(pose[:2], within=within, heading=pose[2])
        self._set(self.chances * np.where(about, sure, 1.0 - sure).ravel())

    @property
    def entropy(self) -> float:
        """Bits, over all states."""
        sound = self.chances[self.chances > 0.0]
        return max(0.0, float(-(sound * np.log2(sound)).sum()))

    @property
    def places(self) -> Floats:
        """The chance of each location, whatever the heading: shape (n,)."""
        return np.asarray(self.chances.reshape(TURNS, -1).sum(axis=0))

    def near(self, at: Point, *, within: float) -> float:
        """The mass of the locations ``within`` metres of a point."""
        locations = self.model.locations.at
        close = np.hypot(locations[:, 0] - at[0], locations[:, 1] - at[1]) <= within
        return float(self.places[close].sum())

    def mass(self, at: Point, *, within: float, heading: float) -> float:
        """The mass of the states ``within`` metres of a point that look about along a heading."""
        about = self._about(at, within=within, heading=heading)
        return float(self.chances.reshape(TURNS, -1)[about].sum())

    def _about(self, at: Point, *, within: float, heading: float) -> NDArray[np.bool_]:
        """Which states those are: shape (4, n)."""
        locations = self.model.locations.at
        close = np.hypot(locations[:, 0] - at[0], locations[:, 1] - at[1]) <= within
        turns = np.cos(np.arange(TURNS) * math.pi / 2 - heading)
        return np.asarray((turns > LOOKING)[:, None] & close)

    def likely(self) -> Pose:
        """The most likely state: the middle of its cell, and the direction it looks in."""
        x, y, theta = self.poses(np.array([self.chances.argmax()]))[0].tolist()
        return (x, y, theta)

    def suspects(
        self, chances: Floats, at: Point, *, within: float, astray: float, share: float
    ) -> tuple[Indices, Floats]:
        """The likeliest states in which a lost robot may be, that have a ``share`` of the mass.

        Those that are believed in, by ``chances``; and with a chance of ``astray``, whatever is
        believed, those ``within`` metres of a point.

        Returns:
            The states, and the mass of each.
        """
        locations = self.model.locations.at
        close = np.hypot(locations[:, 0] - at[0], locations[:, 1] - at[1]) <= within
        around = np.tile(close / max(1, TURNS * int(close.sum())), TURNS)
        mass = (1.0 - astray) * chances + astray * around
        states = np.argsort(-mass, kind="stable")
        most = int(np.searchsorted(mass[states].cumsum(), share * mass.sum())) + 1
        return states[:most], mass[states[:most]]

    def tell(self) -> Belief:
        """The belief as it is published, without what is fainter than `FAINT`."""
        told = np.flatnonzero(self.chances > FAINT)
        order = told[np.argsort(-self.chances[told], kind="stable")]
        shares = self.chances[order]
        return Belief(self.poses(order), shares / shares.sum())

    def poses(self, states: Indices) -> Floats:
        """The middles of the cells of some states, and the directions they look in: (n, 3)."""
        headings, spots = np.divmod(states, len(self.model.locations))
        return np.column_stack([self.model.locations.at[spots], _LOOKS[headings]])

    def _set(self, weights: Floats) -> None:
        total = float(weights.sum())
        if total > 0.0 and math.isfinite(total):
            self.chances = weights / total
        else:
            self.forget()
