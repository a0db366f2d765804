"""Starting together: what is there, and waiting until everything that is needed is."""

from __future__ import annotations

import asyncio

from tca_bus._errors import ConfigError, TimedOutError
from tca_bus._lifecycle import Lifecycle
from tca_bus._presence import Stage


class ReadyTogether(Lifecycle):
    """Says when a module is ready, and waits for others to be."""

    def available(self) -> list[str]:
        """The resources that modules offer now, the modules' own names among them."""
        return sorted(self._parts.core.presence.table.resources())

    def ready(self) -> None:
        """Say that this module is ready; what was held back is delivered from now on."""
        self._parts.enter_stage(Stage.READY)

    async def wait_until_ready(self, *, timeout: float, modules: int = 1) -> None:
        """Wait for what this module requires, then say that it is ready.

        Returns when every resource that it requires is offered, and ``modules`` modules, this one
        among them, are ready or wait as well. What it offers itself counts for others while it
        waits, so that two may require each other.

        Raises:
            ConfigError: ``modules`` is below 1.
            TimedOutError: Not within ``timeout`` wall seconds; it names what is missing. The
                module is as it was before, and may wait again.
        """
        if modules < 1:
            raise ConfigError("modules", modules, "at least 1, this one")
        parts = self._parts
        table, before = parts.core.presence.table, parts.readiness.stage
        parts.enter_stage(Stage.WAITING)
        try:
            async with asyncio.timeout(timeout):
                await parts.core.presence.until(lambda: not parts.readiness.unmet(table, modules))
        except BaseException as error:
            unmet = ", ".join(parts.readiness.unmet(table, modules))
            if not self._is_leaving:
                parts.enter_stage(before)
            if not isinstance(error, TimeoutError):
                raise
            raise TimedOutError(f"module {self.name!r} waits for {unmet}", timeout) from error
        parts.enter_stage(Stage.READY)
