"""The camera that reads door plates."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from tca_bus import Query


class PlateReading(BaseModel):
    """What the camera makes of the door plate before it.

    ``text`` is a room as the map calls it, None when there is no plate to be read; it may be
    misread, and ``confidence`` says how sure the reader is of it, 0 to 1. ``time`` is simulated
    seconds since the epoch.
    """

    model_config = ConfigDict(frozen=True)

    text: str | None
    confidence: float = Field(ge=0.0, le=1.0)
    time: float


class ReadPlate(Query[PlateReading]):
    """Look round for a door plate and read it.

    The same look from the same spot sees the same; move, or wait, for another. A robot without
    a camera does not handle it; one whose camera is gone fails with ``camera_gone``.
    """

    wire_name = "xavierPlate"
