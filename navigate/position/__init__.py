"""Where the robot is: what is believed, and how surely."""

from navigate.position._confidence import Confidence
from navigate.position._estimate import Estimator
from navigate.position._expected import ExpectedRanges

__all__ = [
    "Confidence",
    "Estimator",
    "ExpectedRanges",
]
