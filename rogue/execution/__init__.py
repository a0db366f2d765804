"""Operators carried out by the robot, once each, and verified."""

from __future__ import annotations

from rogue.execution._effects import (
    AwaitCharge,
    Believe,
    CheckTray,
    Effect,
    Locate,
    Look,
    Part,
    Perform,
    Procedure,
    TaskOfRobot,
    Tell,
    Urgency,
)
from rogue.execution._executor import Executor
from rogue.execution._judgement import Case, Verdict, judge
from rogue.execution._layers import Bystander, DoorPlate, Doubt, Layer, NavigatorBelief
from rogue.execution._operators import next_room
from rogue.execution._patience import Patience
from rogue.execution._procedures import acquire, deliver, go_to
from rogue.execution._robot import BusRobot, Endurance, Robot
from rogue.execution._steps import StepRunner
from rogue.execution._verification import SURE, Verification, as_published, layered
from rogue.execution._whereabouts import Evidence, Whereabouts
from rogue.execution._world import KnownWorld

__all__ = [
    "SURE",
    "AwaitCharge",
    "Believe",
    "BusRobot",
    "Bystander",
    "Case",
    "CheckTray",
    "DoorPlate",
    "Doubt",
    "Effect",
    "Endurance",
    "Evidence",
    "Executor",
    "KnownWorld",
    "Layer",
    "Locate",
    "Look",
    "NavigatorBelief",
    "Part",
    "Patience",
    "Perform",
    "Procedure",
    "Robot",
    "StepRunner",
    "TaskOfRobot",
    "Tell",
    "Urgency",
    "Verdict",
    "Verification",
    "Whereabouts",
    "acquire",
    "as_published",
    "deliver",
    "go_to",
    "judge",
    "layered",
    "next_room",
]
