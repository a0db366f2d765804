"""What the robot's range sensors cost a tick, by profile and caster, and what few rays lose.

    uv run python bench/senses.py [--poses 2000] [--json]

Costs are the least of many spells, since a busy machine only adds. Accuracy is that of a perfect
sonar with few rays in its cone, beside one with 201, at random places of the floor, where every
other door is open.
"""

from __future__ import annotations

import argparse
import json
import math
import time

import numpy as np
from numpy.typing import NDArray

from xavier_sim.floors import build_geometry, load_floor
from xavier_sim.messages import SONAR_CONE, SONAR_COUNT, SONAR_FARTHEST, SONAR_RING_RADIUS
from xavier_sim.profile import PROFILES, RobotProfile
from xavier_sim.sensors import Caster, Rays, Senses, make_caster

PLAN = load_floor()
GEOMETRY = build_geometry(PLAN)

CASTERS: tuple[Rays, ...] = ("numpy", "numba")

SPELLS, TICKS = 400, 20
"""Spells that are measured, and ticks of each."""

REFERENCE = 201
"""Rays of a cone that is taken for exact."""

Floats = NDArray[np.float64]
Row = dict[str, float | str]


def cost(profile: RobotProfile, rays: Rays) -> float:
    """Microseconds of a tick's sensing, along a corridor."""
    senses = Senses(profile, GEOMETRY, 1, rays=rays)
    return min(_spell(senses) for _ in range(SPELLS))


def _spell(senses: Senses) -> float:
    began = time.perf_counter()
    for tick in range(TICKS):
        senses.sense(tick, (7.57, 20.0 + 0.1 * tick, 1.57))
    return (time.perf_counter() - began) / TICKS * 1e6


def ring(caster: Caster, pose: Floats, rays: int) -> Floats:
    """What 24 perfect sonars read, metres, with so many rays in a cone."""
    x, y, theta = pose
    facing = theta + np.arange(SONAR_COUNT) * (2.0 * math.pi / SONAR_COUNT)
    spread = np.linspace(-SONAR_CONE / 2, SONAR_CONE / 2, rays)
    mounts = np.column_stack([np.cos(facing), np.sin(facing)]) * SONAR_RING_RADIUS + [x, y]
    met, _ = caster.cast(np.repeat(mounts, rays, axis=0), (facing[:, None] + spread).ravel())
    nearest: Floats = met.reshape(SONAR_COUNT, rays).min(axis=1)
    return np.minimum(nearest, SONAR_FARTHEST)


def losses(counts: list[int], poses: int) -> list[Row]:
    """How far off few rays are, for each count."""
    segments, random = np.concatenate([GEOMETRY.walls, GEOMETRY.doors]), np.random.default_rng(1)
    caster = make_caster("auto", segments, SONAR_FARTHEST)
    for door in range(0, len(GEOMETRY.doors), 2):
        caster.switch(len(GEOMETRY.walls) + door, on=False)
    spaces = [PLAN.spaces[i] for i in random.integers(len(PLAN.spaces), size=poses)]
    off: dict[int, list[Floats]] = {count: [] for count in counts}
    for space in spaces:
        low, high = (space.low.x + 0.4, space.low.y + 0.4), (space.high.x - 0.4, space.high.y - 0.4)
        pose = np.append(random.uniform(low, high), random.uniform(-math.pi, math.pi))
        exact = ring(caster, pose, REFERENCE)
        for count in counts:
            off[count].append(np.abs(ring(caster, pose, count) - exact))
    return [_loss(count, np.concatenate(errors)) for count, errors in off.items()]


def _loss(count: int, error: Floats) -> Row:
    share = float((error > 0.1).mean())
    return {"rays": count, "off_over_10_cm": round(share, 4), "mean_m": round(error.mean(), 4)}


def main() -> None:
    """Read the command line, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--poses", type=int, default=2000)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    costs: list[Row] = [
        {"profile": name, **{f"{rays}_us": round(cost(profile, rays), 1) for rays in CASTERS}}
        for name, profile in PROFILES.items()
    ]
    lost = losses([3, 5, 7, 11, 21], options.poses)
    for row in [*costs, *lost]:
        print(json.dumps(row) if options.json else "  ".join(f"{k} {v}" for k, v in row.items()))


if __name__ == "__main__":
    main()
