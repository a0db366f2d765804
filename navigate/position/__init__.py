"""Where the robot is: what is believed, and how surely."""

from navigate.position._choice import DEFAULT as DEFAULT_LOCALIZER
from navigate.position._choice import Start, make_localizer
from navigate.position._confidence import Confidence
from navigate.position._expected import ExpectedRanges
from navigate.position._localizer import Belief, Estimate, Localizer
from navigate.position._particles import ParticleFilter
from navigate.position._policy import Choice, Directive, Picking, Policy
from navigate.position._pomdp import PomdpLocalizer
from navigate.position._reckoning import DeadReckoning

__all__ = [
    "DEFAULT_LOCALIZER",
    "Belief",
    "Choice",
    "Confidence",
    "DeadReckoning",
    "Directive",
    "Estimate",
    "ExpectedRanges",
    "Localizer",
    "ParticleFilter",
    "Picking",
    "Policy",
    "PomdpLocalizer",
    "Start",
    "make_localizer",
]
