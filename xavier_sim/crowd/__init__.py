"""People who walk the corridors and carts that stand in them: what moves besides the robots."""

from xavier_sim.crowd._crowd import Crowd, NoRoomError

__all__ = [
    "Crowd",
    "NoRoomError",
]
