"""The localizer that the papers tell of: a POMDP says which cell, a tracker where within it.

The Markov belief takes only reports: a metre moved, a quarter turned, a wall or an opening seen.
It may have several peaks, and is never quite sure; the tracker follows one of them to the
centimetre by the walls and jambs around, so that the robot gets through doors. Where the two
disagree for long, or the tracker's readings contradict the map, the robot is lost, and looks for
a pose that fits what is heard among the likely cells. After Koenig & Simmons (1998).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from navigate.body import (
    BEARINGS,
    LocalGrid,
    Motion,
    MotionReports,
    Moved,
    Pose,
    find_axis,
    fresh_sonars,
    look_aside,
    look_front,
    motion_between,
    moved,
    wrap,
)
from navigate.maps import Floats, Floor, Point
from navigate.position._beacons import BeaconTracker
from navigate.position._localizer import NO_BEAMS, Belief, Estimate
from navigate.position._markov_belief import MarkovBelief
from navigate.position._policy import Directive, Picking, Policy
from navigate.position._readings import Readings, seen_from
from navigate.position._rings import Rings
from navigate.position._search import Found, Search
from navigate.position._sonar_model import SonarModel

BATCH = 24
"""Readings of sonars by which the pose is corrected at a time: a ring."""

BATCH_METRES = 0.3
"""Metres after which it is corrected by those that there are."""

MOST_READINGS, MOST_TICKS = 240, 600
"""Readings that are kept for the grid at most, and ticks, of a robot that hears nothing new."""

MEMORY = 0.012
"""Weight of a new reading in the running share of readings that agree."""

LOST_AGREEMENT = 0.5
SOUND_AGREEMENT = 0.65
REGAINED_AGREEMENT = 0.7
"""From which a lost robot is lost no more; at a wrong pose agreement often wavers around half."""

REGAINED_MASS = 0.8
"""Mass of belief that must be near the tracked pose besides: one room has many that are like it."""

SUPPOSED_AGREEMENT = 0.6
"""From which a lost robot goes on as if the tracked pose were right."""

DROPPED = 0.3
"""It supposes another one where belief in this one is less than this share of that in the other."""

REFUTED = 0.2
"""How sure such a pose is once the robot found no way on there: a door may be shut as well."""

FOUND_AGREEMENT = 0.8
LOST_DEVIATION = 1.2
LOST_MASS = 0.02
"""Mass of belief near the tracked pose below which another place may be believed in."""

RIVAL_MASS = 0.5
"""Mass near another pose from which that is."""

BESIDE = 3.0
"""Metres from a sound pose within which belief that has settled elsewhere is a slip of cells."""

CELL = 1.0
"""Metres of deviation beyond which the tracked pose says no more than the cells do."""

DOUBTFUL = 0.6
"""Agreement that speaks neither for nor against the tracked pose.

Among people and shut doors right poses have 0.6 at times. In kidnapped robots wrong ones had 0.0
to 0.6, or up to 0.8 in a corridor like the right one.
"""

VOUCHING = 9.0
"""Logits by which more agreement speaks for it at each report; readings err together."""

SUPPORT = 1.6
"""Metres from the tracked pose within which cells speak for it: it may lie between two."""

STEADY = math.radians(5.0)
"""By how much the direction of the walls may change from one look to the next to be known."""

CONTRADICTED = 0.3
"""What is left for the chance to be anywhere, at each report, while readings contradict."""

COVERED = 0.98
"""Belief that lies in the likely states among which a lost robot looks for a pose that fits."""

ASTRAY = 0.5
"""What a lost robot leaves for the chance to be in any cell a metre around, whatever it believed.

The farther it has to look around, the less: it was looked for there in vain, and cells have
had the time to tell.
"""

UNHEARD = 0.3
"""Share of the belief that must speak for a directive."""

FOUND_SHARE = 0.95
"""Share that a pose must have of what a ring of readings speaks for, to be taken."""

FOUND_MASS = 0.7
"""Belief that is put on such a pose."""

_WAYS = {
    Directive.FORWARD: 0.0,
    Directive.LEFT: math.pi / 2,
    Directive.RIGHT: -math.pi / 2,
}


class PomdpLocalizer:
    """The Markov belief and the tracker together.

    Args:
        floor: the map.
        known: whether the robot starts where the map says, rather than anywhere.
        picking: how the directive for a belief that is spread out is picked.
    """

    STATE: ClassVar[tuple[str, ...]] = (
        "agreement", "markov", "_tracker", "_reports", "_readings", "_grid",
        "_support", "_rivalled", "_contradicted", "_refuted", "_search", "_rings", "_asked_at",
        "directives",
    )  # fmt: skip

    def __init__(self, floor: Floor, *, known: bool = True, picking: Picking = "voting") -> None:
        self._sonar = SonarModel(floor)
        self.markov = MarkovBelief.of_floor(floor)
        self._tracker = BeaconTracker(floor)
        self._reports = MotionReports()
        self._readings = Readings()
        self._grid = LocalGrid()
        self.directives, self._picking = Policy(self.markov.model), picking
        self._search = Search(self._sonar.expected)
        self._rings = Rings(self.markov.model)
        self._asked_at: Pose = (0.0, 0.0, 0.0)
        self.agreement, self._support = 1.0, 1.0
        self._rivalled = self._contradicted = self._refuted = False
        start = floor.plan.start
        self.place((start.x, start.y, floor.plan.start_heading))
        if not known:
            self.forget()

    @property
    def estimate(self) -> Estimate:
        """The tracked pose."""
        tracker = self._tracker
        return Estimate(*tracker.pose, *tracker.deviations, self.agreement)

    @property
    def lost(self) -> bool:
        """Whether readings contradict the tracked pose, or belief has left it."""
        wide = self._tracker.deviations[0] > LOST_DEVIATION
        return wide or self._contradicted or self._rivalled

    @property
    def supposes(self) -> bool:
        """Whether it is lost, but what is heard fits the tracked pose: one of many, maybe."""
        known = self._tracker.deviations[0] < CELL and not self._refuted
        return self._contradicted and known and self.agreement >= SUPPOSED_AGREEMENT

    @property
    def entropy(self) -> float:
        """Of the Markov belief, bits."""
        return self.markov.entropy

    def belief(self) -> Belief:
        """The Markov belief."""
        return self.markov.tell()

    def doubt(self) -> None:
        """Take in that a robot that is lost cannot well be at the estimate: it found no way on."""
        self.markov.favour(self._tracker.pose, within=SUPPORT, sure=REFUTED)
        self._rings.settle()
        self._refuted = True
        self._weigh()

    def way_to(self, goal: Point) -> float | None:
        """Which way to go on the belief, radians to the left of ahead; None for no advice.

        A new goal takes a second or two of calls before there is any. The directive is picked as
        ``picking`` says; where that is to stop, or little of the belief speaks for it, there is
        none.
        """
        if self.directives.goal != goal:
            self.directives.aim(goal)
        if not self.directives.work():
            return None
        choice = self.directives.choose(self.markov.chances, picking=self._picking)
        if choice.share < UNHEARD or choice.directive not in _WAYS:
            return None
        return _WAYS[choice.directive] - self._reports.turned

    def forget(self) -> None:
        """Know nothing: the robot may be anywhere."""
        self.markov.forget()
        self._rings.forget()
        self._tracker.widen(spread=20.0, turn_spread=2.0)
        self.agreement = 0.0
        self._judge()
        self._weigh()

    def place(self, pose: Pose, *, spread: float = 0.05, turn_spread: float = 0.03) -> None:
        """Believe to be at ``pose``, give or take: standard deviations in metres and radians."""
        self._tracker.place(pose, spread=spread, turn_spread=turn_spread)
        self._reports.begin(pose[2])
        self._readings.clear()
        self._search.stop()
        self._rings.forget()
        self._grid.clear()
        self.markov.know(pose, spread=spread, turn_spread=turn_spread)
        self.agreement, self._refuted = 1.0, False
        self._weigh()
        self._judge()

    def orient(self, theta: float, *, spread: float) -> None:
        """Correct the tracked heading, and with it the axis of the walls."""
        self._tracker.orient(theta, spread=spread)
        self._align()

    def widen(self, *, spread: float, turn_spread: float) -> None:
        """Doubt the position more: somebody may have moved the robot unseen."""
        self._tracker.widen(spread=spread, turn_spread=turn_spread)
        share = 1.0 - math.exp(-spread)
        self.markov.know(self._tracker.pose, spread=spread, turn_spread=turn_spread, share=share)
        self._weigh()

    def move(self, motion: Motion) -> None:
        """Take in a motion; once it comes to a metre, also what was seen on the way."""
        if motion.still():
            return
        self._tracker.move(motion)
        for report in self._reports.move(motion):
            self._read(still=False)
            self.markov.report(report)
            self._rings.report(report, looking=self._search.busy)
            if isinstance(report, Moved):
                self._see()
            self._vouch()
            self._weigh()

    def sense(self, ranges: Floats, fresh: int, *, still: bool, striper: Floats = NO_BEAMS) -> None:
        """Take in the fresh ones of 24 ``ranges``; they are made use of a ring at a time."""
        self._readings.add(self._reports.pose, list(fresh_sonars(fresh)), ranges, striper)
        if self._readings.fresh >= BATCH or self._tracker.metres >= BATCH_METRES:
            self._read(still=still)
        if self._readings.count >= MOST_READINGS or self._readings.ticks >= MOST_TICKS:
            self._enter()
        if (found := self._search.go_on()) is not None:
            self._take(found, ranges)
        if not self.lost:
            self._search.forget()

    def _read(self, *, still: bool) -> None:
        """Track by what was heard since the last time."""
        heard = self._readings.latest()
        sound = np.isfinite(heard.ranges)
        if not sound.any():
            self._tracker.settle()
            return
        sonars = seen_from(self._reports.pose, heard)[sound]
        agrees = self._tracker.sense(sonars, heard.ranges[sound], still=still)
        memory = MEMORY * (0.3 if still else 1.0)
        for one in agrees.tolist():
            self.agreement += memory * (one - self.agreement)
        self._judge()
        self._align()

    def _enter(self) -> None:
        """Enter what was heard and seen in the grid."""
        heard, seen = self._readings.everything()
        self._readings.clear()
        self._grid.follow(*self._reports.pose[:2])
        self._grid.see(seen.poses, seen.beams)
        self._grid.hear(heard.poses, BEARINGS[heard.sonars], heard.ranges)

    def notice(self, spots: Sequence[Point], *, within: float, sure: float) -> None:
        """Weigh the cells by a sight that is to be had near one of ``spots``."""
        self.markov.notice(spots, within=within, sure=sure)
        self._weigh()

    def mass_near(self, x: float, y: float, *, within: float) -> float:
        """The belief that lies ``within`` metres of a point, 0 to 1.

        Cells that speak for the tracked pose count as far as that pose is likely to be there, once
        it is known better than to a cell.
        """
        here, mass = self.estimate, self.markov.near((x, y), within=within)
        if here.deviation > CELL:
            return mass
        away = math.dist((here.x, here.y), (x, y))
        sigma = max(here.deviation / math.sqrt(2.0), 0.02)
        inside = 0.5 * (1.0 + math.erf((within - away) / (sigma * math.sqrt(2.0))))
        others = max(0.0, mass - self._support)
        return min(1.0, self._support * inside + others)

    def fit(self, pose: Pose, ranges: Floats) -> float:
        """The share of a ring of readings that a robot at ``pose`` would have, 0 to 1."""
        return self._sonar.fit(pose, ranges)

    def recover(self, ranges: Floats, *, radius: float) -> None:
        """Begin to look for a pose that fits a ring of readings, unless that is under way.

        It is looked for in likely cells and within ``radius`` metres of the estimate, once the
        direction of the walls around is known.
        """
        if self._search.busy:
            return
        if not self._find_axis():
            return
        here = self._reports.pose
        prior = self._rings.prior(self.markov.chances, here)
        if prior is None:
            return
        states, mass = self.markov.suspects(
            prior, self._tracker.pose[:2],
            within=radius, astray=ASTRAY / max(1.0, radius), share=COVERED,
        )  # fmt: skip
        middles = self.markov.poses(states)
        middles[:, 2] += self._reports.turned
        self._asked_at = here
        self._search.begin(middles, mass, ranges)
        self._rings.ask(prior, states, here)

    def _take(self, found: Found, ranges: Floats) -> None:
        """Take the pose that was found, and moved from since, if the robot is still lost."""
        if not self.lost:
            return
        pose = moved(found.pose, motion_between(self._asked_at, self._reports.pose))
        fits = self._sonar.fit(pose, ranges)
        sure = found.share >= FOUND_SHARE and fits >= FOUND_AGREEMENT
        if not sure:
            self.markov.chances = self._rings.weigh(self.markov.chances, found.fits)
            self._weigh()
        if sure or (fits >= FOUND_AGREEMENT and self._is_likelier(pose)):
            self._tracker.place(pose, spread=0.15, turn_spread=0.1)
            self._refuted = False
            self._readings.latest()
            if sure:
                self.markov.know(pose, share=FOUND_MASS)
            self.agreement = fits
            self._weigh()
            self._judge()
            self._align()

    def _is_likelier(self, pose: Pose) -> bool:
        """Whether a lost robot had better suppose to be at a pose than go on as it supposes."""
        mass = self.markov.mass(pose[:2], within=SUPPORT, heading=pose[2])
        return not self.supposes or self._support < DROPPED * mass

    def _align(self) -> None:
        """Tell the axis of the walls by the tracker, or by the walls while that is lost."""
        if not self._contradicted or self.supposes:
            self._reports.align(self._reports.pose[2] - self._tracker.pose[2])

    def _find_axis(self) -> bool:
        """Tell the axis by the walls around, while lost; whether it was known to be there."""
        self._enter()
        if not self.lost or self.supposes:
            return True
        if (axis := find_axis(self._grid)) is None:
            return False
        off = wrap(4.0 * (axis - self._reports.axis)) / 4.0
        self._reports.align(axis)
        return abs(off) <= STEADY

    def _see(self) -> None:
        self._find_axis()
        if self.agreement < LOST_AGREEMENT:
            doubt = (LOST_AGREEMENT - self.agreement) / LOST_AGREEMENT
            self.markov.forget(CONTRADICTED * doubt * self._support)
        facing = self._reports.facing
        self.markov.see(
            look_front(self._grid, facing),
            look_aside(self._grid, facing, left=True),
            look_aside(self._grid, facing, left=False),
        )

    def _vouch(self) -> None:
        """Let the cells know how well what is heard fits the tracked pose."""
        if self._tracker.deviations[0] < CELL:
            sure = 1.0 / (1.0 + math.exp(VOUCHING * (DOUBTFUL - self.agreement)))
            if self._contradicted:
                sure = min(sure, 0.5)
            self.markov.favour(self._tracker.pose, within=SUPPORT, sure=sure)

    def _judge(self) -> None:
        """Whether readings contradict the tracked pose: from little agreement until much of it."""
        if self.agreement < LOST_AGREEMENT:
            self._contradicted = True
        elif self.agreement >= REGAINED_AGREEMENT and self._support >= REGAINED_MASS:
            self._contradicted = self._refuted = False

    def _weigh(self) -> None:
        """How much of the belief speaks for the tracked pose."""
        x, y, theta = self._tracker.pose
        self._support = self.markov.mass((x, y), within=SUPPORT, heading=theta)
        self._rivalled = self._support < LOST_MASS and self._rival() > RIVAL_MASS
        if self._rivalled and self.agreement >= SOUND_AGREEMENT and self._is_beside():
            self.markov.know((x, y, theta), share=FOUND_MASS)
            self._support = self.markov.mass((x, y), within=SUPPORT, heading=theta)
            self._rivalled = False

    def _is_beside(self) -> bool:
        """Whether the most likely state is but a few cells off the tracked pose."""
        x, y, _ = self.markov.likely()
        return math.dist((x, y), self._tracker.pose[:2]) < BESIDE

    def _rival(self) -> float:
        """How much of the belief speaks for the most likely state."""
        x, y, theta = self.markov.likely()
        return self.markov.mass((x, y), within=SUPPORT, heading=theta)
