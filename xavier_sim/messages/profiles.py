"""Names of the robots that there are, as `xavier run` takes them."""

from __future__ import annotations

from typing import Literal

ProfileName = Literal["hard", "modern", "xavier"]
"""Xavier on its bad days, a robot of today with a lidar, or Xavier as a rule."""
