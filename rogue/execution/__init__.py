"""Operators carried out by the robot, once each, and verified."""

from __future__ import annotations

from rogue.execution._effects import (
    Believe,
    Effect,
    Locate,
    Pause,
    Perform,
    Procedure,
    TaskOfRobot,
    Tell,
)
from rogue.execution._executor import Executor
from rogue.execution._procedures import Patience, acquire, deliver, go_to
from rogue.execution._robot import BusRobot, Endurance, Robot
from rogue.execution._steps import StepRunner

__all__ = [
    "Believe",
    "BusRobot",
    "Effect",
    "Endurance",
    "Executor",
    "Locate",
    "Patience",
    "Pause",
    "Perform",
    "Procedure",
    "Robot",
    "StepRunner",
    "TaskOfRobot",
    "Tell",
    "acquire",
    "deliver",
    "go_to",
]
