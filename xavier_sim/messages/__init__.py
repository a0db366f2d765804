"""Messages that the robot and its speech board serve: what a real robot would serve too."""

from xavier_sim.messages.battery import Battery, BatteryState, ReadBattery
from xavier_sim.messages.camera import PlateReading, ReadPlate
from xavier_sim.messages.doors import DoorMoved, DoorState, MoveDoor, WorldDoors
from xavier_sim.messages.faults import AnyFault, CameraPower, Fault, FaultState, Kidnap, Slip
from xavier_sim.messages.floorplan import Corner, Door, FloorPlan, Space, SpaceKind
from xavier_sim.messages.people import (
    ItemAction,
    ItemMoved,
    MoveItem,
    MovePerson,
    Occupant,
    WhoIsIn,
)
from xavier_sim.messages.robot import (
    BUMP_PANELS,
    SONAR_CONE,
    SONAR_COUNT,
    SONAR_FARTHEST,
    SONAR_NEAREST,
    SONAR_RING_RADIUS,
    Drive,
    Sensors,
    TrueLocation,
    WhereReally,
)
from xavier_sim.messages.speech import Ask, Heard, Say, Spoken, Subject, Typed

__all__ = [
    "BUMP_PANELS",
    "SONAR_CONE",
    "SONAR_COUNT",
    "SONAR_FARTHEST",
    "SONAR_NEAREST",
    "SONAR_RING_RADIUS",
    "AnyFault",
    "Ask",
    "Battery",
    "BatteryState",
    "CameraPower",
    "Corner",
    "Door",
    "DoorMoved",
    "DoorState",
    "Drive",
    "Fault",
    "FaultState",
    "FloorPlan",
    "Heard",
    "ItemAction",
    "ItemMoved",
    "Kidnap",
    "MoveDoor",
    "MoveItem",
    "MovePerson",
    "Occupant",
    "PlateReading",
    "ReadBattery",
    "ReadPlate",
    "Say",
    "Sensors",
    "Slip",
    "Space",
    "SpaceKind",
    "Spoken",
    "Subject",
    "TrueLocation",
    "Typed",
    "WhereReally",
    "WhoIsIn",
    "WorldDoors",
]
