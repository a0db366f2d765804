"""Messages that the robot and its speech board serve: what a real robot would serve too."""

from xavier_sim.messages.floorplan import Corner, Door, FloorPlan, Space, SpaceKind
from xavier_sim.messages.robot import (
    BUMP_PANELS,
    SONAR_CONE,
    SONAR_COUNT,
    SONAR_FARTHEST,
    SONAR_NEAREST,
    SONAR_RING_RADIUS,
    DoorState,
    Drive,
    MoveDoor,
    Sensors,
    TrueLocation,
    WhereReally,
    WorldDoors,
)
from xavier_sim.messages.speech import Ask, Heard, ItemMoved, Say, Spoken, Typed

__all__ = [
    "BUMP_PANELS",
    "SONAR_CONE",
    "SONAR_COUNT",
    "SONAR_FARTHEST",
    "SONAR_NEAREST",
    "SONAR_RING_RADIUS",
    "Ask",
    "Corner",
    "Door",
    "DoorState",
    "Drive",
    "FloorPlan",
    "Heard",
    "ItemMoved",
    "MoveDoor",
    "Say",
    "Sensors",
    "Space",
    "SpaceKind",
    "Spoken",
    "TrueLocation",
    "Typed",
    "WhereReally",
    "WorldDoors",
]
