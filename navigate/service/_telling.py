"""Tells all who listen what is believed, and how the drive goes."""

from __future__ import annotations

import logging
import math

from navigate.driving import Drive
from navigate.messages import Belief, BeliefState, Outlook, Progress
from navigate.navigator import Navigator
from navigate.reporting import belief_state, drive_progress, outlook
from navigate.service._whereabouts_log import WhereaboutsLog
from tca_bus import Module
from xavier_sim.messages import Sensors

log = logging.getLogger(__name__)

PERIOD = 1.0
"""Simulated seconds between two beliefs, and between two words on a drive."""


class Teller:
    """Broadcasts `Belief` and `Progress`, once in a `PERIOD` and no oftener."""

    def __init__(self, navigator: Navigator, module: Module) -> None:
        self._navigator, self._module = navigator, module
        self._drive: Drive | None = None
        self._task = ""
        self._told_at = -math.inf
        self._told: BeliefState | None = None
        self._faults: dict[str, str] = {}
        self._whereabouts = WhereaboutsLog()

    def believed(self) -> BeliefState:
        """The belief now."""
        return belief_state(self._navigator, self._drive.goal if self._drive else None)

    def outlook(self, sensors: Sensors | None) -> Outlook:
        """All that is seen, believed and wanted, with the latest ``sensors``."""
        return outlook(self._navigator, sensors, self._drive, self._task)

    def began(self, drive: Drive, task: str) -> None:
        """A drive has begun for a task: tell of it at the next tick."""
        self._drive, self._task, self._told_at = drive, task, -math.inf

    async def ended(self) -> None:
        """The drive is over: tell how things stand."""
        await self._tell()
        self._drive = None

    async def stepped(self) -> None:
        """The navigator took in a reading."""
        self._say_faults(self._navigator.perception.faults)
        self._whereabouts.stepped(self._navigator)
        if abs(self._navigator.time - self._told_at) >= PERIOD - 1e-3:
            await self._tell()

    def _say_faults(self, faults: dict[str, str]) -> None:
        """Say once of each sense that it is not believed any more, and that it is again."""
        known, self._faults = self._faults, faults
        for sense in sorted(faults.keys() - known.keys()):
            log.warning("%s is %s and is left out until it behaves", sense, faults[sense])
        for sense in sorted(known.keys() - faults.keys()):
            log.warning("%s behaves again", sense)

    async def _tell(self) -> None:
        self._told_at = self._navigator.time
        if self._drive is not None:
            drive = drive_progress(self._navigator, self._drive, self._task)
            await self._module.broadcast(Progress(drive=drive))
        state = self.believed()
        if self._told is None or state.cells != self._told.cells or self._drive is not None:
            self._told = state
            await self._module.broadcast(Belief(state=state))
