"""What all processes of an office cost together."""

from __future__ import annotations

import os
import re
import time
from pathlib import Path

from tca_bus.launcher import Launcher
from xavier_sim.soak import Cost

HIGH_WATER = re.compile(r"VmHWM:\s+(\d+) kB")


class Spending:
    """Adds up wall time, processor time and the memory at its peak, from now on.

    A process that was started again is counted from its beginning. Only Linux tells; elsewhere
    processor time and memory stay 0.
    """

    def __init__(self, launcher: Launcher, names: list[str]) -> None:
        self.cost = Cost()
        self._launcher, self._names = launcher, names
        self._wall, self._cpu = time.perf_counter(), self._processor_seconds()

    def read(self, *, early: bool) -> None:
        """Take in what was spent so far; ``early`` in the first simulated hour."""
        self.cost.wall = time.perf_counter() - self._wall
        self.cost.cpu = self._processor_seconds() - self._cpu
        self.cost.memory = max(self.cost.memory, self._megabytes())
        if early or self.cost.memory_early == 0.0:
            self.cost.memory_early = self.cost.memory

    def _processor_seconds(self) -> float:
        ticks = 0
        for text in self._read_all("stat"):
            fields = text.rpartition(")")[2].split()
            ticks += int(fields[11]) + int(fields[12])
        return ticks / os.sysconf("SC_CLK_TCK")

    def _megabytes(self) -> float:
        found = [HIGH_WATER.search(text) for text in self._read_all("status")]
        return sum(int(one.group(1)) for one in found if one) / 1024.0

    def _read_all(self, name: str) -> list[str]:
        files = [Path(f"/proc/{self._launcher.pid(one)}/{name}") for one in self._names]
        return [file.read_text() for file in files if file.exists()]
