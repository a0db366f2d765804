"""How to go there: manoeuvres, obstacle avoidance, doors, reactive safety."""

from navigate.driving._doorlog import DoorLog, DoorTally
from navigate.driving._doorwatch import DoorWatch
from navigate.driving._drive import Drive, GoalFailedError
from navigate.driving._driver import Driver
from navigate.driving._safety import must_stop
from navigate.driving._strangers import STRANGERS_WITHIN, Strangers
from navigate.driving._surroundings import Surroundings
from navigate.driving._view import STOP, View, Wheels

__all__ = [
    "STOP",
    "STRANGERS_WITHIN",
    "DoorLog",
    "DoorTally",
    "DoorWatch",
    "Drive",
    "Driver",
    "GoalFailedError",
    "Strangers",
    "Surroundings",
    "View",
    "Wheels",
    "must_stop",
]
