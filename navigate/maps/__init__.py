"""Maps: floors from files, their spaces, walls and passages."""

from navigate.maps._floor import CENTIMETRES, Floor, UnknownRoomError, frame, inset, is_room
from navigate.maps._floorfile import MapError, load_plan
from navigate.maps._walls import Floats, Passage, Point

__all__ = [
    "CENTIMETRES",
    "Floats",
    "Floor",
    "MapError",
    "Passage",
    "Point",
    "UnknownRoomError",
    "frame",
    "inset",
    "is_room",
    "load_plan",
]
