"""What perfect sonars would read on the true floor."""

from __future__ import annotations

import numpy as np
from navigate_loop import true_plan

from navigate.body import BEARINGS, RING_RADIUS
from navigate.maps import Floor
from xavier_sim.floors import build_geometry
from xavier_sim.profile import XAVIER
from xavier_sim.sensors import RayCaster

TRUE = Floor(true_plan())
CASTER = RayCaster(build_geometry(true_plan()).walls, XAVIER.sonar.farthest)
ALL = (1 << 24) - 1


def ring(x, y, theta):
    """What 24 perfect sonars read there, cones of 21 rays, doors open."""
    look = theta + BEARINGS
    starts = np.column_stack([x + RING_RADIUS * np.cos(look), y + RING_RADIUS * np.sin(look)])
    spread = np.linspace(-0.19, 0.19, 21)
    distance, _ = CASTER.cast(np.repeat(starts, 21, axis=0), (look[:, None] + spread).ravel())
    return distance.reshape(24, 21).min(axis=1)
