"""How to go there: manoeuvres, obstacle avoidance, doors, reactive safety."""

from navigate.driving._driver import Drive, Driver
from navigate.driving._safety import must_stop
from navigate.driving._surroundings import Surroundings
from navigate.driving._view import STOP, View, Wheels

__all__ = ["STOP", "Drive", "Driver", "Surroundings", "View", "Wheels", "must_stop"]
