"""What a soak costs the machine: time and memory, over all processes that carried it on."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass

MEGABYTE = 1024.0 * 1024.0


@dataclass
class Cost:
    """Seconds by the wall and of the processor, and megabytes at the peak.

    ``memory_early`` is the peak after the first simulated hour, or the first job after it.
    """

    wall: float = 0.0
    cpu: float = 0.0
    memory_early: float = 0.0
    memory: float = 0.0

    def __add__(self, other: Cost) -> Cost:
        """Both together: times are added up, memory is that of the greater one."""
        return Cost(
            wall=self.wall + other.wall,
            cpu=self.cpu + other.cpu,
            memory_early=max(self.memory_early, other.memory_early),
            memory=max(self.memory, other.memory),
        )


class Meter:
    """Adds what is spent from now on to a cost."""

    def __init__(self, cost: Cost) -> None:
        self.cost = cost
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def read(self, *, early: bool) -> None:
        """Take in what was spent since the last time; ``early`` in the first simulated hour."""
        wall, cpu = time.perf_counter(), time.process_time()
        self.cost.wall += wall - self._wall
        self.cost.cpu += cpu - self._cpu
        self._wall, self._cpu = wall, cpu
        self.cost.memory = max(self.cost.memory, peak_memory())
        if early or self.cost.memory_early == 0.0:
            self.cost.memory_early = self.cost.memory


def peak_memory() -> float:
    """The most memory that this process has held so far, megabytes; 0 where that is not told."""
    if sys.platform == "win32":
        return 0.0
    import resource  # noqa: PLC0415 - not there on every system

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / MEGABYTE if sys.platform == "darwin" else peak / 1024.0
