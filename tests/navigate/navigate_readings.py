"""Sensor readings made by hand."""

from __future__ import annotations

from typing import Any

import numpy as np

from xavier_sim.messages import SONAR_COUNT, Sensors

ALL_FRESH = (1 << SONAR_COUNT) - 1


def reading(tick: int = 1, time: float | None = None, **fields: Any) -> Sensors:
    """What a robot senses that stands with 5 m of room all around it, but for ``fields``.

    Not validated: some tests want what no robot sends.
    """
    sound = {
        "period": 0.1,
        "lockstep": False,
        "sonar": np.full(SONAR_COUNT, 5.0, dtype=np.float32),
        "sonar_fresh": ALL_FRESH,
        "odom": np.zeros(3, dtype=np.float32),
        "speed": 0.0,
        "turn_rate": 0.0,
        "bump": 0,
        "striper": np.empty(0, dtype=np.float32),
        "lidar": np.empty(0, dtype=np.float32),
    }
    at = 1000.0 + tick / 10 if time is None else time
    return Sensors.model_construct(tick=tick, time=at, **(sound | fields))
