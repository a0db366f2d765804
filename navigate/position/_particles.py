"""A particle filter over odometry and sonar, on the metric map.

Each particle carries a pose and its own guess of how the heading drifts by the metre. Readings
of neighbouring sonars err together, so likelihoods are tempered. After Thrun, Burgard & Fox,
Probabilistic Robotics, chapter 8.3, with resampling of low variance and roughening.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np

from navigate.body import Motion, Pose, fresh_sonars, moved, wrap
from navigate.maps import Floats, Floor, Point, inset
from navigate.position._localizer import NO_BEAMS, Belief, Estimate, in_cells
from navigate.position._sonar_model import SonarModel, agreeing, log_likelihood
from xavier_sim.messages import Space

PARTICLES = 250
DRIFT = 0.006
"""Spread of the heading drift of a base, radians per metre."""

METRE_NOISE = 0.03
"""Doubt about the distance: metres per square root of a metre."""

SCALE_NOISE = 0.02
"""Doubt about the distance: metres per metre, for every step anew."""

HEADING_NOISE = 0.012
"""Doubt about the heading: radians per square root of a metre."""

TURN_NOISE = 0.02
"""Doubt about a turn: radians per square root of a radian."""

TEMPER = 0.45
"""Exponent of a reading's likelihood: the errors of neighbouring readings go together."""

STILL_TEMPER = 0.02
"""The same while the robot stands, when every reading says again what the last one said."""

MEMORY = 0.012
"""Weight of a new reading in the running share of readings that agree."""

FARTHEST_LOOK = 3.0
"""Standard deviations beyond which all headings are as improbable: it may be told wrongly."""

LOST_AGREEMENT = 0.5
LOST_DEVIATION = 1.2
FOUND_AGREEMENT = 0.8


class ParticleFilter:
    """The filter. It is deterministic: the same seed and inputs give the same estimates."""

    STATE: ClassVar[tuple[str, ...]] = (
        "agreement", "_x", "_y", "_theta", "_drift", "_weights", "_estimate", "_random",
    )  # fmt: skip

    def __init__(self, floor: Floor, *, seed: int = 0, particles: int = PARTICLES) -> None:
        self._floor = floor
        self._sonar = SonarModel(floor)
        self._random = np.random.default_rng(seed)
        self._count = particles
        start = floor.plan.start
        self.place((start.x, start.y, floor.plan.start_heading))

    def place(self, pose: Pose, *, spread: float = 0.05, turn_spread: float = 0.03) -> None:
        """Believe to be at ``pose``, give or take: standard deviations in metres and radians."""
        draw = self._random.standard_normal((4, self._count))
        self._set_all(*pose)
        self._x += spread * draw[0]
        self._y += spread * draw[1]
        self._theta += turn_spread * draw[2]
        self._drift += DRIFT * draw[3]
        self.agreement = 1.0
        self._estimate = self._average()

    def orient(self, theta: float, *, spread: float) -> None:
        """Weigh the particles by which way the robot looks."""
        off = 2.0 * np.sin((self._theta - theta) / 2.0) / spread
        self._weights -= 0.5 * np.minimum(off**2, FARTHEST_LOOK**2)
        self._weights -= self._weights.max()
        self._estimate = self._average()

    def widen(self, *, spread: float, turn_spread: float) -> None:
        """Doubt the position more: somebody may have moved the robot unseen."""
        draw = self._random.standard_normal((2, 2, self._count))
        self._x += spread * draw[0, 0]
        self._y += spread * draw[0, 1]
        self._theta += turn_spread * draw[1, 0]
        self._estimate = self._average()

    def move(self, motion: Motion) -> None:
        """Move all particles as odometry says, with the doubts above."""
        if motion.still():
            return
        draw = self._random.standard_normal((3, self._count))
        metres, root = motion.metres, math.sqrt(motion.metres)
        ahead = motion.ahead + (METRE_NOISE * root + SCALE_NOISE * metres) * draw[0]
        turn = motion.turn - self._drift * metres + HEADING_NOISE * root * draw[1]
        turn += TURN_NOISE * math.sqrt(abs(motion.turn)) * draw[2]
        heading = self._theta + turn / 2
        cos, sin = np.cos(heading), np.sin(heading)
        self._x += ahead * cos - motion.aside * sin
        self._y += ahead * sin + motion.aside * cos
        self._theta += turn
        x, y, theta = moved(self._estimate.pose, motion)
        self._estimate = replace(self._estimate, x=x, y=y, theta=theta)

    def sense(self, ranges: Floats, fresh: int, *, still: bool, striper: Floats = NO_BEAMS) -> None:
        """Weigh the particles by the fresh ones of 24 ``ranges`` (metres from the ring)."""
        del striper
        heard = np.array([i for i in fresh_sonars(fresh) if math.isfinite(ranges[i])], np.intp)
        if len(heard) == 0:
            self._estimate = self._average()
            return
        here, readings = self._estimate, ranges[heard]
        x, y = np.append(self._x, here.x), np.append(self._y, here.y)
        expected = self._sonar.expect(x, y, np.append(self._theta, here.theta), heard)
        self._judge(agreeing(readings, expected[:, -1]), still=still)
        weights = log_likelihood(readings, expected[:, :-1])
        weights *= STILL_TEMPER if still else TEMPER
        self._weights += weights
        self._weights -= self._weights.max()
        shares = np.exp(self._weights)
        if shares.sum() ** 2 < 0.5 * self._count * (shares @ shares):
            self._resample(shares)
        self._estimate = self._average()

    @property
    def estimate(self) -> Estimate:
        """What is believed now."""
        return self._estimate

    @property
    def lost(self) -> bool:
        """Whether the sonars contradict the estimate persistently, or it is spread too wide."""
        return self.agreement < LOST_AGREEMENT or self._estimate.deviation > LOST_DEVIATION

    @property
    def supposes(self) -> bool:
        """Never."""
        return False

    def doubt(self) -> None:
        """Take no notice."""

    def belief(self) -> Belief:
        """The particles gathered in cells."""
        return in_cells(self._x, self._y, self._theta, np.exp(self._weights))

    def notice(self, spots: Sequence[Point], *, within: float, sure: float) -> None:
        """Weigh the particles by a sight that is to be had near one of ``spots``."""
        near = np.zeros(self._count, dtype=np.bool_)
        for x, y in spots:
            near |= np.hypot(self._x - x, self._y - y) <= within
        self._weights += np.log(np.where(near, sure, 1.0 - sure))
        self._weights -= self._weights.max()
        self._estimate = self._average()

    def mass_near(self, x: float, y: float, *, within: float) -> float:
        """The share of belief that lies ``within`` metres of a point, 0 to 1."""
        shares = np.exp(self._weights)
        near = np.hypot(self._x - x, self._y - y) <= within
        return float(shares[near].sum() / shares.sum())

    def fit(self, pose: Pose, ranges: Floats) -> float:
        """The share of a ring of readings that a robot at ``pose`` would have, 0 to 1."""
        return self._sonar.fit(pose, ranges)

    def recover(self, ranges: Floats, *, radius: float) -> None:
        """Search poses within ``radius`` metres for those that fit the whole ring of readings."""
        heard = np.flatnonzero(np.isfinite(ranges))
        if len(heard) == 0:
            return
        self._scatter(radius, count=8 * self._count)
        weights = self._sonar.log_likelihood(self._x, self._y, self._theta, ranges[heard], heard)
        self._weights = weights - weights.max()
        self._resample(np.exp(0.7 * self._weights))
        self._estimate = self._average()
        fits = self.fit(self._estimate.pose, ranges)
        found = fits >= FOUND_AGREEMENT and self._estimate.deviation < LOST_DEVIATION
        self.agreement = fits if found else 0.0

    def way_to(self, goal: Point) -> float | None:
        """None: particles all over the floor give no advice."""

    def _set_all(self, x: float, y: float, theta: float) -> None:
        self._x: Floats = np.full(self._count, x)
        self._y: Floats = np.full(self._count, y)
        self._theta: Floats = np.full(self._count, theta)
        self._drift: Floats = np.zeros(self._count)
        self._weights = np.zeros(self._count)

    def _scatter(self, radius: float, *, count: int) -> None:
        here = self._estimate
        spots = _free_spots(self._floor, self._random, here, radius, count)
        self._x, self._y = spots[:, 0].copy(), spots[:, 1].copy()
        self._theta = here.theta + 0.25 * self._random.standard_normal(len(spots))
        self._drift = DRIFT * self._random.standard_normal(len(spots))

    def _judge(self, agrees: Floats, *, still: bool) -> None:
        memory = MEMORY * (0.3 if still else 1.0)
        for one in agrees.tolist():
            self.agreement += memory * (one - self.agreement)

    def _resample(self, shares: Floats) -> None:
        """Draw particles anew in proportion to their weights, and roughen the copies."""
        points = (self._random.random() + np.arange(self._count)) / self._count
        chosen = np.searchsorted(np.cumsum(shares / shares.sum()), points)
        chosen = chosen.clip(max=len(shares) - 1)
        draw = self._random.standard_normal((4, self._count))
        self._x = self._x[chosen] + 0.008 * draw[0]
        self._y = self._y[chosen] + 0.008 * draw[1]
        self._theta = self._theta[chosen] + 0.003 * draw[2]
        self._drift = self._drift[chosen] + 0.0003 * draw[3]
        self._weights = np.zeros(self._count)

    def _average(self) -> Estimate:
        shares = np.exp(self._weights)
        shares /= shares.sum()
        x, y = float(shares @ self._x), float(shares @ self._y)
        spread = shares @ ((self._x - x) ** 2 + (self._y - y) ** 2)
        cos, sin = float(shares @ np.cos(self._theta)), float(shares @ np.sin(self._theta))
        length = min(1.0, math.hypot(cos, sin))
        turn_spread = math.sqrt(max(0.0, -2.0 * math.log(max(length, 1e-9))))
        theta = wrap(math.atan2(sin, cos))
        return Estimate(x, y, theta, math.sqrt(float(spread)), turn_spread, self.agreement)


def _free_spots(
    floor: Floor, random: np.random.Generator, here: Estimate, radius: float, count: int
) -> Floats:
    """Points (count, 2), even over the free floor within ``radius`` metres of ``here``."""
    boxes = [_clip(space, here, radius) for space in floor.plan.spaces]
    sound = np.array([box for box in boxes if box[2] > box[0] and box[3] > box[1]])
    if len(sound) == 0:
        return np.tile([here.x, here.y], (count, 1))
    areas = (sound[:, 2] - sound[:, 0]) * (sound[:, 3] - sound[:, 1])
    box = sound[random.choice(len(sound), size=count, p=areas / areas.sum())]
    return np.asarray(box[:, :2] + random.random((count, 2)) * (box[:, 2:] - box[:, :2]))


def _clip(space: Space, here: Estimate, radius: float) -> tuple[float, float, float, float]:
    margin = 0.25
    if inset(space, here.x, here.y) < -radius:
        return (0.0, 0.0, 0.0, 0.0)
    return (
        max(space.low.x + margin, here.x - radius),
        max(space.low.y + margin, here.y - radius),
        min(space.high.x - margin, here.x + radius),
        min(space.high.y - margin, here.y + radius),
    )
