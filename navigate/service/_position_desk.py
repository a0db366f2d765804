"""Where the robot is believed to be: asked, told, seen."""

from __future__ import annotations

from navigate.messages import Position, SetPosition, WhereAmI
from navigate.navigator import Navigator
from navigate.service._map_desk import told_unknown
from tca_bus import Context, Module, TaskContext


class PositionDesk:
    """Serves the position estimate, and takes in what others know of it."""

    def __init__(self, navigator: Navigator, module: Module) -> None:
        self._navigator = navigator
        module.serve(WhereAmI, self._on_where)
        module.serve(SetPosition, self._on_set_position)

    async def _on_where(self, _query: WhereAmI, _context: Context) -> Position:
        return self._navigator.position()

    async def _on_set_position(self, command: SetPosition, _context: TaskContext) -> Position:
        with told_unknown():
            return self._navigator.set_position(command.room)
