"""How long central counts on a module that is out of reach.

Presence is quick and may err: a module behind a cut link is as invisible as a dead one. So a
vanished module gets no more tasks at once, but keeps those it has until it is sure to be gone:
its next start is there, or it did not come back within ``lost_after`` while central itself was
connected.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from tca_bus._errors import ConfigError
from tca_bus._presence import RECONNECT_GRACE, PresentModule
from tca_bus.tasktree import ProviderAppeared

if TYPE_CHECKING:
    from tca_bus._central import Central

LOST_AFTER = 2.0
"""Wall seconds after presence has lost a module until its tasks are given up."""

LOOK_PERIOD = 0.1
"""Wall seconds between two looks at an absent module and at central's own link."""


def check_lost_after(seconds: float) -> float:
    """The value if it can be one.

    Raises:
        ConfigError: It is below zero, infinite or no number.
    """
    if not 0 <= seconds < math.inf:
        raise ConfigError("--lost-after", seconds, "a number of seconds, 0 or more")
    return seconds


class Absences:
    """Waits for modules that are out of central's reach."""

    def __init__(self, central: Central, *, lost_after: float) -> None:
        self._central = central
        self._lost_after = check_lost_after(lost_after)
        self._changed = asyncio.Event()
        self._latest: dict[str, object] = {}

    def presence_changed(self) -> None:
        """Have all who wait look again."""
        self._changed.set()
        self._changed = asyncio.Event()

    async def outlast(self, module: PresentModule) -> bool:
        """Give a module no more tasks and wait for it; False when it is lost for good."""
        self._hold_back(module)
        # Should it come back and vanish again unseen, its later absence is the one that counts.
        key, absence = module.incarnation, object()
        self._latest[key] = absence
        try:
            return await self._outlast(module, lambda: self._latest.get(key) is not absence)
        finally:
            if self._latest.get(key) is absence:
                del self._latest[key]

    async def _outlast(self, module: PresentModule, is_superseded: Callable[[], bool]) -> bool:
        deadline = time.monotonic() + self._lost_after
        while not (self._is_present(module) or is_superseded()):
            if not self._central.module.is_connected:
                # Central itself is cut off: the module may be back before central sees it.
                await self._central.module.connected()
                deadline = time.monotonic() + max(self._lost_after, RECONNECT_GRACE)
            if self._is_replaced(module) or time.monotonic() >= deadline:
                return False
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(LOOK_PERIOD):
                    await self._changed.wait()
        return True

    def awaited(self) -> set[str]:
        """The incarnations that central waits for."""
        return set(self._latest)

    def predecessors(self, module: PresentModule) -> list[str]:
        """Earlier starts of a module that have tasks and are not there any more."""
        present = {m.incarnation for m in self._central.module.modules()}
        return [
            incarnation
            for incarnation, name in self._central.tree.holders().items()
            if name == module.name
            and incarnation < module.incarnation
            and incarnation not in present
        ]

    def _hold_back(self, module: PresentModule) -> None:
        if module.incarnation in self._central.tree.holders():
            away = ProviderAppeared(self._central.now(), module.name, module.incarnation, {})
            self._central.happen(away)

    def _is_present(self, module: PresentModule) -> bool:
        return any(m.incarnation == module.incarnation for m in self._central.module.modules())

    def _is_replaced(self, module: PresentModule) -> bool:
        """Whether a later start of the same module is there."""
        return any(
            m.name == module.name and m.incarnation > module.incarnation
            for m in self._central.module.modules()
        )
