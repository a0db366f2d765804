"""What a soak has come to: its jobs, and what was measured at every second of them."""

from __future__ import annotations

from typing import Any

from xavier_sim.soak._histogram import Histogram
from xavier_sim.soak._jobs import JOBS, Job

ERROR_BIN, ERROR_BINS = 0.01, 1000
"""Metres of a bin of position errors, up to ten."""

SPEED_BIN, SPEED_BINS = 0.01, 200
"""Metres per second of a bin of speeds, up to two."""

MOVING = 0.02
"""Metres per second from which the robot drives."""


class Tally:
    """Jobs in their order, and distributions of what was measured."""

    def __init__(self) -> None:
        self.jobs: list[Job] = []
        self.rescues = 0
        self.door_moves = 0
        self.faults = 0
        self.errors = Histogram(width=ERROR_BIN, bins=ERROR_BINS)
        self.speeds = Histogram(width=SPEED_BIN, bins=SPEED_BINS)

    def sample(self, *, error: float, speed: float) -> None:
        """Count the metres between belief and truth, and the speed while driving."""
        self.errors.add(error)
        if abs(speed) >= MOVING:
            self.speeds.add(abs(speed))

    def add_all(self, other: Tally) -> None:
        """Count all that another one has counted."""
        self.jobs.extend(other.jobs)
        self.rescues += other.rescues
        self.door_moves += other.door_moves
        self.faults += other.faults
        self.errors.add_all(other.errors)
        self.speeds.add_all(other.speeds)

    def snapshot(self) -> dict[str, Any]:
        """What `restore` needs."""
        return {
            "jobs": JOBS.dump_python(self.jobs, mode="json"),
            "rescues": self.rescues,
            "door_moves": self.door_moves,
            "faults": self.faults,
            "errors": self.errors.snapshot(),
            "speeds": self.speeds.snapshot(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        self.jobs = JOBS.validate_python(state["jobs"])
        self.rescues, self.door_moves = state["rescues"], state["door_moves"]
        # Checkpoints from before faults were counted have none.
        self.faults = state.get("faults", 0)
        self.errors.restore(state["errors"])
        self.speeds.restore(state["speeds"])
