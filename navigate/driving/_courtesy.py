"""Courtesy: how fast to drive where people are, and when to stand and wait for them.

The speed is such that the robot stands before it meets somebody who walks towards it from the
moment at which they were last heard or seen. Whoever stands in the way is waited for, then passed.
"""

from __future__ import annotations

import math

from navigate.body import ROBOT_RADIUS
from navigate.driving._strangers import Stranger, Strangers
from navigate.driving._view import View
from navigate.maps import Point

WALKING = 1.2
"""Metres per second at which somebody may come towards the robot."""

STALE = 0.4
"""Seconds that a reading may be old: one round of the sonars."""

BRAKES = 1.0
"""Metres per second squared that the base can brake for sure."""

KEEP_OFF = 0.15
"""Metres to keep from whoever is ahead."""

SOCIAL = 0.2
"""Metres beside the robot that must be free for it to pass somebody without a wait."""

WAIT_AT = 0.9
"""Metres ahead of the robot at which it stands and waits."""

WAIT_SECONDS, WAIT_FOR_WALKERS = 3.0, 8.0
"""How long the robot waits for what stands, and for what still moves."""

PASSING_SPEED = 0.3
PASSING_WITHIN = 1.1
"""Metres from the robot's centre within which somebody is passed slowly."""

ACROSS = math.tan(math.radians(70.0))
"""Of the angle off its way up to which the robot minds that whoever walks may walk into it."""

CREEP_SPEED, CREEP_WITHIN = 0.1, 0.8
"""Metres per second at which the robot may touch somebody, and metres from its centre within which
whoever is there may set out into it before the sonars tell, however long they have stood."""

LET_GO = 0.5
"""Seconds after which a wait is over when nobody is there any more."""

KNOWN_FOR = 30.0
"""Seconds for which it is not waited again for what stands at the same place."""

KNOWN_WITHIN = 0.8


class Courtesy:
    """The robot's manners on one drive, to ``strangers``; to nobody without."""

    def __init__(self, strangers: Strangers | None = None) -> None:
        self._strangers = Strangers() if strangers is None else strangers
        self.waited = 0.0
        self._since, self._last = -math.inf, -math.inf
        self._known: list[tuple[float, Point]] = []

    def speed(self, view: View, heading: float, top: float, *, wary: bool = False) -> float:
        """The speed to drive at along ``heading``, m/s, up to ``top``; 0.0 to stand and wait.

        ``wary`` says that somebody may come round a corner, who may be here before a sonar hears
        them twice.
        """
        met = [(one, *_seen_from(view.at, heading, one.at)) for one in self._strangers.around]
        if self._waits(view.time, met):
            return 0.0
        for one, x, y in met:
            if x > 0.0:
                top = min(top, _speed_towards(one, x, y, view.time, wary=wary))
        return min(top, self._facing_speed(view))

    def _facing_speed(self, view: View) -> float:
        """The speed that those allow who are before or beside the robot as it looks now.

        That need not be along its way: it may still turn into that, or out of it round something.
        """
        certain = (one for one in self._strangers.around if one.certain)
        seen = (_seen_from(view.at, view.pose[2], one.at) for one in certain)
        return min(
            (_beside(math.hypot(x, y)) for x, y in seen if x > -ROBOT_RADIUS),
            default=math.inf,
        )

    def _waits(self, now: float, met: list[tuple[Stranger, float, float]]) -> bool:
        """Whether to stand, for somebody who is not known to stay there."""
        waiting = now - self._last < LET_GO
        reach, side = (1.3, 2.0) if waiting else (1.0, 1.0)
        near = [
            one
            for one, x, y in met
            if one.certain
            and 0.0 < x < ROBOT_RADIUS + reach * WAIT_AT
            and abs(y) < ROBOT_RADIUS + side * SOCIAL
            and not self._knows(one.at, now)
        ]
        if not near:
            return False
        if not waiting:
            self._since = self._last = now
        self.waited += now - self._last
        self._last = now
        stand = all(one.stands(now) for one in near)
        if now - self._since < (WAIT_SECONDS if stand else WAIT_FOR_WALKERS):
            return True
        self._known += [(now, one.at) for one in near]
        return False

    def _knows(self, at: Point, now: float) -> bool:
        self._known = [(time, spot) for time, spot in self._known if now - time < KNOWN_FOR]
        return any(math.dist(spot, at) < KNOWN_WITHIN for _, spot in self._known)


def approach_speed(room: float, walking: float = WALKING) -> float:
    """The speed from which the robot stands before ``room`` metres are gone.

    They go by what it drives until it has noticed, what it needs to brake, and what somebody
    walks towards it meanwhile: ``room = v t + v^2 / 2b + walking (t + v / b)``.
    """
    left = room - walking * STALE
    if left <= 0.0:
        return 0.0
    slow = STALE + walking / BRAKES
    return BRAKES * (math.sqrt(slow**2 + 2.0 * left / BRAKES) - slow)


def _speed_towards(one: Stranger, x: float, y: float, now: float, *, wary: bool) -> float:
    """The speed that somebody allows who is ``x`` metres ahead, and ``y`` to the left."""
    away, walks, top = math.hypot(x, y), not one.stands(now), math.inf
    if walks and abs(y) < ROBOT_RADIUS + SOCIAL:
        walking = WALKING if one.certain else 0.0
        top = approach_speed(x - ROBOT_RADIUS - KEEP_OFF, walking)
    if one.certain:
        top = min(top, _beside(away))
    if walks and (one.certain or wary) and abs(y) < ACROSS * x:
        come = WALKING * max(0.0, now - one.seen - STALE) if wary else 0.0
        top = min(top, approach_speed(away - come - ROBOT_RADIUS - KEEP_OFF))
    return top


def _beside(away: float) -> float:
    """The speed to pass somebody at, m/s, so many metres from the robot's centre."""
    if away < CREEP_WITHIN:
        return CREEP_SPEED
    return PASSING_SPEED if away < PASSING_WITHIN else math.inf


def _seen_from(here: Point, heading: float, at: Point) -> Point:
    """A point of the map from ``here``: metres ahead along a heading, and to the left."""
    dx, dy = at[0] - here[0], at[1] - here[1]
    cos, sin = math.cos(heading), math.sin(heading)
    return dx * cos + dy * sin, dy * cos - dx * sin
