"""Faults on command: done to the world, mended, and told."""

from __future__ import annotations

import math

from xavier_sim.messages import (
    AnyFault,
    CameraPower,
    FaultState,
    Kidnap,
    LaserOffset,
    Mend,
    Slip,
    SonarFault,
    WheelSlip,
)
from xavier_sim.robot import Robot
from xavier_sim.world import World


def make_fault(world: World, fault: AnyFault, robot: str | None = None) -> None:
    """Do a fault to a robot, or mend it, at this very tick.

    Args:
        world: in which it is.
        fault: what happens to it.
        robot: its name; the first one when not given.

    Raises:
        UnknownDoorError: it is to be put down in a room that there is not.
        NotFreeError: it does not fit where it is to be put down.
        NoSensorError: it has no such sensor.
    """
    one = world.robots[robot] if robot else world.robot
    match fault:
        case CameraPower(on=on):
            one.camera.is_on = on
        case Slip(metres=metres, turn=turn):
            one.slip(metres, turn)
        case WheelSlip(share=share, veer=veer):
            one.wheels.slip, one.wheels.veer = share, veer
        case SonarFault(number=number, state="sound"):
            one.senses.mend_sonar(number)
        case SonarFault(number=number, state="dead"):
            one.senses.stick_sonar(number, math.inf)
        case SonarFault(number=number, metres=metres):
            one.senses.stick_sonar(number, metres)
        case LaserOffset(metres=metres, turn=turn):
            one.senses.knock_lasers(metres, turn)
        case Kidnap():
            world.kidnap(*_destination(world, one, fault), fault.theta, robot)
        case Mend():
            _mend(one)


def fault_state(world: World, time: float, robot: str | None = None) -> FaultState:
    """What is wrong with a robot now.

    Args:
        world: in which it is.
        time: simulated seconds since the epoch.
        robot: its name; the first one when not given.
    """
    one, truth = world.robots[robot] if robot else world.robot, world.truth(robot)
    metres, turn = one.senses.laser_offset
    return FaultState(
        camera_on=one.camera.is_on,
        slip=one.slipping,
        wheels=WheelSlip(share=one.wheels.slip, veer=one.wheels.veer),
        sonars=tuple(_faulty(*stuck) for stuck in sorted(one.senses.stuck_sonars.items())),
        laser=LaserOffset(metres=metres, turn=turn),
        room=truth.room,
        space=truth.space,
        tick=truth.tick,
        time=time,
    )


def _mend(robot: Robot) -> None:
    robot.camera.is_on = True
    robot.slip(-robot.slipping, 0.0)
    robot.wheels.slip = robot.wheels.veer = 0.0
    for number in robot.senses.stuck_sonars:
        robot.senses.mend_sonar(number)
    if robot.senses.laser_offset != (0.0, 0.0):
        robot.senses.knock_lasers(0.0, 0.0)


def _destination(world: World, robot: Robot, fault: Kidnap) -> tuple[float, float]:
    if fault.room is not None:
        return world.place_of(fault.room)
    if fault.x is not None and fault.y is not None:
        return fault.x, fault.y
    return robot.beside(fault.ahead, fault.left)


def _faulty(number: int, reading: float) -> SonarFault:
    if math.isinf(reading):
        return SonarFault(number=number, state="dead")
    return SonarFault(number=number, state="stuck", metres=reading)
