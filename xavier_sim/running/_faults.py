"""Faults on command, as they are done to the world."""

from __future__ import annotations

import math

from xavier_sim.messages import AnyFault, CameraPower, Kidnap, LaserOffset, Slip, SonarFault
from xavier_sim.world import World


def make_fault(world: World, fault: AnyFault) -> None:
    """Do a fault to the first robot of a world, at this very tick.

    Raises:
        UnknownDoorError: it is to be put down in a room that there is not.
        NotFreeError: it does not fit where it is to be put down.
        NoSensorError: it has no such sensor.
    """
    robot = world.robot
    match fault:
        case CameraPower(on=on):
            robot.camera.is_on = on
        case Slip(metres=metres, turn=turn):
            robot.slip(metres, turn)
        case SonarFault(number=number, state="sound"):
            robot.senses.mend_sonar(number)
        case SonarFault(number=number, state="dead"):
            robot.senses.stick_sonar(number, math.inf)
        case SonarFault(number=number, metres=metres):
            robot.senses.stick_sonar(number, metres)
        case LaserOffset(metres=metres, turn=turn):
            robot.senses.knock_lasers(metres, turn)
        case Kidnap():
            world.kidnap(*_destination(world, fault), fault.theta)


def _destination(world: World, fault: Kidnap) -> tuple[float, float]:
    if fault.room is not None:
        return world.place_of(fault.room)
    if fault.x is not None and fault.y is not None:
        return fault.x, fault.y
    return world.robot.beside(fault.ahead, fault.left)
