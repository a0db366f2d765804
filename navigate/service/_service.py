"""The ``navigate`` module: the navigator on the bus."""

from __future__ import annotations

from navigate.keeping import StateFile
from navigate.navigator import Navigator
from navigate.service._goal_desk import GoalDesk
from navigate.service._helm import Helm
from navigate.service._keeper import keep, load
from navigate.service._map_desk import MapDesk
from navigate.service._position_desk import PositionDesk
from navigate.service._telling import Teller
from tca_bus import BusOptions, Module

NAME = "navigate"


class NavigateService:
    """Serves a `Navigator` on the bus, with its state in ``kept`` if that is given.

    It goes on from the state that is kept there, unless ``goes_on`` is false.

    Use: ``await NavigateService(navigator, options).run()``; it runs until cancelled.
    """

    def __init__(
        self,
        navigator: Navigator,
        options: BusOptions | None,
        kept: StateFile | None = None,
        *,
        goes_on: bool = True,
    ) -> None:
        self.module = Module(NAME, options=options, sole=True)
        self._navigator, self._kept, self._goes_on = navigator, kept, goes_on
        self._teller = Teller(navigator, self.module)
        self._helm = Helm(navigator, self.module, self._stepped, self._broke)
        self._goals = GoalDesk(navigator, self.module, self._helm, self._teller)
        PositionDesk(navigator, self.module, self._helm, self._teller)
        MapDesk(navigator, self.module)

    async def run(self) -> None:
        """Serve until cancelled.

        Raises:
            BusGoneError: there is no router.
            RefusedError: there is a navigator on the realm.
        """
        if self._kept is not None and self._goes_on:
            load(self._navigator, self._kept)
        async with self.module:
            if self._kept is not None:
                saving = keep(self._navigator, self._kept, sensed=self._has_sensed)
                self.module.start(saving, name="navigate keeps its state")
            await self.module.serve_forever()

    def _has_sensed(self) -> bool:
        return self._helm.sensors is not None

    async def _stepped(self, leapt: bool) -> None:
        self._goals.stepped(leapt=leapt)
        await self._teller.stepped()

    def _broke(self, error: Exception) -> None:
        self._goals.broke(error)
