"""How probable it is that the robot stands at each place, and what evidence makes of that.

Places are the rooms of the floor. Those that some evidence names are kept one by one; all
others share what is left evenly. Source: Haigh & Veloso (1997), *Execution and Monitoring*.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

PLACES = 60
"""Places between which the robot might have to tell where nobody says how many there are."""

LEAST, MOST = 0.001, 0.999
"""Nothing that a sensor or a person says is held for impossible or for certain."""


def bounded(probability: float) -> float:
    """Keep a probability off 0 and 1, which no later evidence could move."""
    return min(max(probability, LEAST), MOST)


@dataclass(frozen=True, slots=True)
class Evidence:
    """How probable an observation is at each place: at those named, and at any other."""

    at: Mapping[str, float]
    elsewhere: float


@dataclass(frozen=True, slots=True)
class Whereabouts:
    """A distribution over places; a fresh one knows nothing.

    ``named`` has probabilities of single places, ``rest`` that of all others together, of which
    there are ``others``.
    """

    named: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    rest: float = 1.0
    others: int = PLACES

    def of(self, room: str) -> float:
        """How probable it is that the robot is at ``room``."""
        if room in self.named:
            return self.named[room]
        return self.rest / self.others if self.others > 0 else 0.0

    def likeliest(self) -> tuple[str, float] | None:
        """The named place that is most probable, and how probable it is."""
        return max(self.named.items(), key=lambda item: item[1], default=None)

    def updated(self, evidence: Evidence) -> Whereabouts:
        """The distribution after an observation, by Bayes's rule."""
        rooms = dict.fromkeys([*self.named, *evidence.at])
        split = sum(self.of(room) for room in rooms if room not in self.named)
        others = max(1, PLACES - len(rooms))
        weights = {r: self.of(r) * evidence.at.get(r, evidence.elsewhere) for r in rooms}
        rest = (self.rest - split) * evidence.elsewhere
        total = sum(weights.values()) + rest
        if total <= 0.0:
            return self
        named = {room: weight / total for room, weight in weights.items()}
        return Whereabouts(MappingProxyType(named), rest / total, others)


def both(one: Evidence, other: Evidence) -> Evidence:
    """Two observations that do not depend on each other, taken as one."""
    rooms = dict.fromkeys([*one.at, *other.at])
    at = {r: one.at.get(r, one.elsewhere) * other.at.get(r, other.elsewhere) for r in rooms}
    return Evidence(at, one.elsewhere * other.elsewhere)


def stated(room: str, confidence: float, places: int = PLACES) -> Evidence:
    """Evidence by which one who knew nothing comes to believe in ``room`` so much.

    A navigator's confidence is such a posterior, over all ``places``.
    """
    sure = bounded(confidence)
    return Evidence({room: sure * places}, (1.0 - sure) * places / (places - 1))


def read(room: str, confidence: float, places: int = PLACES) -> Evidence:
    """Evidence of a sign that says ``room``, read rightly with probability ``confidence``.

    A misread sign may say any other room.
    """
    right = bounded(confidence)
    return Evidence({room: right}, (1.0 - right) / (places - 1))
