"""What the localizers cost: a report to the Markov belief, directives, and a tick of each.

    python bench/belief.py

Medians in milliseconds on the whole floor, one core. A tick of a localizer is one motion and the
six sonars that fire then; the others are single calls.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import time
from collections.abc import Callable

import numpy as np

from navigate.body import Front, Motion, Moved, Side, Turned
from navigate.maps import Floor, load_plan
from navigate.position import ParticleFilter, Policy, PomdpLocalizer

TIMES = 400
POSE = (7.52, 25.0, math.pi / 2)
GOAL = "r-5321"


def milliseconds(call: Callable[[], object], times: int = TIMES) -> float:
    """The median of what a call costs."""
    call()
    spent = []
    for _ in range(times):
        began = time.perf_counter()
        call()
        spent.append(time.perf_counter() - began)
    return round(1000 * statistics.median(spent), 4)


def row() -> dict[str, float | int]:
    """The figures under the names that are printed."""
    floor = Floor(load_plan())
    pomdp, particles = PomdpLocalizer(floor), ParticleFilter(floor)
    belief, ranges = pomdp.markov, np.full(24, 1.4)
    still = Motion(0.0, 0.0, 0.0)
    for localizer in (pomdp, particles):
        localizer.place(POSE, spread=0.2)
    policy, goal = Policy(belief.model), floor.place(GOAL)
    policy.aim(goal)
    sweeps = list[float]()
    while not policy.settled:
        began = time.process_time()
        policy.work()
        sweeps.append(round(1000 * (time.process_time() - began), 4))

    def tick(localizer: PomdpLocalizer | ParticleFilter, way: float = 0.002) -> None:
        localizer.move(Motion(way, 0.0, 0.0) if way else still)
        localizer.sense(ranges, 0x111111, still=False)

    def whole_report() -> None:
        belief.report(Moved(0))
        belief.see(Front.CLEAR, Side.WALL, Side.SMALL)

    return {
        "states": belief.model.size,
        "motion_report": milliseconds(lambda: belief.report(Moved(0))),
        "turn_report": milliseconds(lambda: belief.report(Turned(1))),
        "sensor_report": milliseconds(lambda: belief.see(Front.CLEAR, Side.WALL, Side.SMALL)),
        "update": milliseconds(whole_report),
        "entropy": milliseconds(lambda: belief.entropy),
        "mass_at_goal": milliseconds(lambda: belief.near(floor.place(GOAL), within=0.6)),
        "new_goal_ticks": len(sweeps),
        "new_goal_tick": max(sweeps),
        "voting": milliseconds(lambda: policy.choose(belief.chances)),
        "mls": milliseconds(lambda: policy.choose(belief.chances, picking="mls")),
        "qmdp": milliseconds(lambda: policy.choose(belief.chances, picking="qmdp")),
        "pomdp_tick": milliseconds(lambda: tick(pomdp)),
        "particles_tick": milliseconds(lambda: tick(particles)),
    }


def main() -> None:
    """Parse the command line and print the figures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    figures = row()
    lines = [f"{name:16} {value}" for name, value in figures.items()]
    print(json.dumps(figures) if parser.parse_args().json else "\n".join(lines))


if __name__ == "__main__":
    main()
