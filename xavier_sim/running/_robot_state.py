"""The world together with its time, and both as they are kept on disk."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from tca_bus import Module
from xavier_sim.messages import (
    BatteryState,
    DoorState,
    FaultState,
    Sensors,
    Standing,
    TrueLocation,
    WorldView,
)
from xavier_sim.profile import TICK
from xavier_sim.robot import Reading, Robot
from xavier_sim.running._faults import fault_state
from xavier_sim.running._outlet import Outlet
from xavier_sim.running._pacing import may_tick
from xavier_sim.running._reflex import Reflex
from xavier_sim.running._robot_desk import RobotDesk
from xavier_sim.running._simulated_time import SimClock
from xavier_sim.snapshots import Saved
from xavier_sim.world import World

RESERVE = 10
"""Ticks that the world may go on after it was saved, before it must be saved again: one that was
killed falls back by no more than the way of a second."""


class RobotState:
    """A world, the clock that counts its ticks as time, and the tick it may reach unsaved.

    Args:
        world: freshly made.
        clock: the time of its ticks.
        speed: simulated seconds per wall second, None for lockstep.
        name: of the robot that is shown to the bus; the first one when not given.
    """

    def __init__(
        self, world: World, clock: SimClock, *, speed: float | None, name: str | None = None
    ) -> None:
        self.world, self.clock, self.speed = world, clock, speed
        self.name = name or next(iter(world.robots))
        self.tick_limit, self.patience = world.tick, math.inf
        self.reflex: Reflex | None = None
        self._kept_reflex: Reflex | None = None

    @property
    def robot(self) -> Robot:
        """The robot that is shown to the bus."""
        return self.world.robots[self.name]

    @property
    def tick(self) -> int:
        """The control tick that the world is at."""
        return self.world.tick

    @property
    def reading(self) -> Reading:
        """What the robot senses at this tick."""
        return self.robot.reading

    @property
    def is_over(self) -> bool:
        """Whether there is no further tick: a world goes on for ever."""
        return False

    @property
    def now(self) -> float:
        """Simulated seconds since the epoch."""
        return self.clock.time_of(self.world.tick)

    @property
    def must_save(self) -> bool:
        """Whether the next tick may come only after the world was saved."""
        return self.world.tick >= self.tick_limit

    def attach(self, reflex: Reflex) -> None:
        """Let the base's reflex sense each reading from this one on, or go on from where it was."""
        if self._kept_reflex is None:
            reflex.sense(self.reading)
        else:
            reflex.restore(self._kept_reflex.snapshot())
        self.reflex = reflex

    async def advance(self, speed: float, turn_rate: float) -> Reading:
        """Drive for a tick, m/s and rad/s, and sense."""
        self.world.step(speed, turn_rate)
        self.feel()
        return self.reading

    def feel(self) -> None:
        """Let the reflex sense the reading of a new tick."""
        if self.reflex is not None:
            self.reflex.sense(self.reading)

    def may_tick(
        self, *, driven: bool, answered: bool, busy: bool, moving: bool, holding: bool
    ) -> bool:
        """Whether time may move by a tick in lockstep; see `xavier_sim.running._pacing`."""
        return may_tick(driven=driven, answered=answered, busy=busy, moving=moving, holding=holding)

    def awaited(self, *, driven: bool, busy: bool) -> None:
        """A world without a driver, or whose driver has no goal, waits for nothing."""

    def wake_by(self, wake: Callable[[], None]) -> None:
        """Nothing but its driver and those who wait for a time move it."""
        del wake

    def open_desk(self, module: Module, outlet: Outlet, changed: Callable[[], None]) -> RobotDesk:
        """Serve what is asked of the robot beside driving."""
        return RobotDesk(self, module, outlet, changed)

    def saved(self, *, stopped: bool = False) -> Saved:
        """What to keep now; the next `tick_limit` is in it, and counts once it is on disk.

        Args:
            stopped: whether this world goes on no more in this process.
        """
        return Saved(
            clock_start=self.clock.start,
            tick_limit=self.world.tick + RESERVE,
            world=self.world.snapshot(),
            stopped=stopped,
            reflexes=self.reflexes(),
        )

    def restore(self, saved: Saved, *, at_least: float) -> None:
        """Go on from what was kept: at that very tick, or after a crash at one nobody has heard of.

        Args:
            saved: of a world with the same floor.
            at_least: a time before which the clock must not stand, seconds since the epoch.
        """
        tick = saved.world["tick"] if saved.stopped else saved.tick_limit + 1
        self.world.restore({**saved.world, "tick": tick})
        self.clock = SimClock(saved.clock_start).moved_to(tick, at_least)
        self.tick_limit = tick
        self.keep_reflex(saved)

    def reflexes(self) -> dict[str, dict[str, Any]]:
        """The states of the reflexes in this world, by the robot's name."""
        return {self.name: self.reflex.snapshot()} if self.reflex is not None else {}

    def keep_reflex(self, saved: Saved) -> None:
        """Take from what was kept the state with which the robot's reflex is to go on."""
        if self.name in saved.reflexes:
            self._kept_reflex = Reflex()
            self._kept_reflex.restore(saved.reflexes[self.name])

    def sensors(self) -> Sensors:
        """The reading of the current tick as a message."""
        reading = self.robot.reading
        return Sensors.model_construct(
            tick=reading.tick,
            time=self.now,
            period=TICK,
            lockstep=self.speed is None,
            sonar=reading.sonar,
            sonar_fresh=reading.sonar_fresh,
            odom=reading.odom,
            speed=reading.speed,
            turn_rate=reading.turn_rate,
            bump=reading.bump,
            striper=reading.striper,
            lidar=reading.lidar,
        )

    def true_location(self) -> TrueLocation:
        """Where the robot really is, as a message."""
        truth = self.world.truth(self.name)
        return TrueLocation(
            x=truth.x,
            y=truth.y,
            theta=truth.theta,
            room=truth.room,
            space=truth.space,
            metres=truth.metres,
            bumps=truth.bumps,
            tick=truth.tick,
            time=self.now,
            people_touched=truth.people_touched,
            people_hit=truth.people_hit,
            hardest_hit=truth.hardest_hit,
        )

    def door_states(self) -> list[DoorState]:
        """Every door as a message."""
        return [
            DoorState(room=one.room, open=one.is_open, door=one.name)
            for one in self.world.each_door
        ]

    def standing(self) -> list[Standing]:
        """People, carts and other robots, as messages; always in the same order."""
        others = [robot.disc for robot in self.world.robots.values() if robot is not self.robot]
        return [
            Standing(x=disc.x, y=disc.y, radius=disc.radius, person=disc.person)
            for disc in (*self.world.discs, *others)
        ]

    def world_view(self) -> WorldView:
        """All that one sees who looks on, as a message."""
        return WorldView(
            floor=self.world.plan,
            doors=self.door_states(),
            robot=self.true_location(),
            standing=self.standing(),
        )

    def battery_state(self) -> BatteryState:
        """How full the battery is, as a message; a robot without one is always full."""
        battery = self.robot.battery
        return BatteryState(
            charge=round(battery.charge, 6) if battery else 1.0,
            low=battery is not None and battery.low,
            charging=battery is not None and battery.charging,
            charger=self.world.plan.charger,
            time=self.now,
        )

    def fault_state(self) -> FaultState:
        """What is wrong with the robot, as a message."""
        return fault_state(self.world, self.now, self.name)
