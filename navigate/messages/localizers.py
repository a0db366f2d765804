"""Names of what can tell the navigator where the robot is, as `navigate run` takes them."""

from __future__ import annotations

from typing import Literal

LocalizerName = Literal["pomdp", "particles", "odometry"]
"""A POMDP over the topological map, a particle filter on the metric one, or odometry alone."""
