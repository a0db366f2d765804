"""Where the robot is believed to be: asked, told, seen."""

from __future__ import annotations

from navigate.messages import (
    BeliefState,
    Believed,
    Look,
    NoticeLandmark,
    Outlook,
    Position,
    SetPosition,
    ShowOutlook,
    Sight,
    WhereAmI,
)
from navigate.navigator import Navigator
from navigate.service._helm import Helm
from navigate.service._map_desk import told_unknown
from navigate.service._telling import Teller
from tca_bus import (
    Context,
    HandlerFailedError,
    Module,
    NoHandlerError,
    PeerLostError,
    TaskContext,
    TaskError,
    TimedOutError,
)
from xavier_sim.messages import PlateReading, ReadPlate

LOOK_SECONDS = 5.0
"""Wall seconds that the camera has to read a plate."""


class PositionDesk:
    """Serves the position estimate, and takes in what others know of it."""

    def __init__(self, navigator: Navigator, module: Module, helm: Helm, teller: Teller) -> None:
        self._navigator, self._module = navigator, module
        self._helm, self._teller = helm, teller
        module.serve(WhereAmI, self._on_where)
        module.serve(Believed, self._on_believed)
        module.serve(SetPosition, self._on_set_position)
        module.serve(NoticeLandmark, self._on_notice)
        module.serve(Look, self._on_look)
        module.serve(ShowOutlook, self._on_outlook)

    async def _on_where(self, _query: WhereAmI, _context: Context) -> Position:
        return self._navigator.position()

    async def _on_believed(self, _query: Believed, _context: Context) -> BeliefState:
        return self._teller.believed()

    async def _on_set_position(self, command: SetPosition, _context: TaskContext) -> Position:
        with told_unknown():
            return self._navigator.set_position(command.room, theta=command.theta)

    async def _on_notice(self, command: NoticeLandmark, _context: TaskContext) -> Position:
        with told_unknown():
            return self._navigator.notice(command.room, sure=command.confidence)

    async def _on_outlook(self, _query: ShowOutlook, _context: Context) -> Outlook:
        return self._teller.outlook(self._helm.sensors)

    async def _on_look(self, _query: Look, _context: Context) -> Sight:
        reading = await self._read_plate()
        known = reading.text in self._navigator.floor.places
        seen = self._navigator.mass_seeing(reading.text) if reading.text and known else 0.0
        return Sight(
            plate=reading.text,
            confidence=reading.confidence,
            expected=seen,
            position=self._navigator.position(),
        )

    async def _read_plate(self) -> PlateReading:
        try:
            return await self._module.query(ReadPlate(), timeout=LOOK_SECONDS)
        except NoHandlerError as error:
            raise TaskError("no_camera", "the robot has no camera that reads plates") from error
        except HandlerFailedError as error:
            raise TaskError(error.failure.name, error.failure.text) from error
        except (PeerLostError, TimedOutError) as error:
            raise TaskError("camera_gone", f"the camera does not answer: {error}") from error
