"""Several robots in one world, each shown on a realm of its own, that tick together."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

from tca_bus import BusOptions, Module
from xavier_sim.robot import Reading
from xavier_sim.running._outlet import Outlet, Witness
from xavier_sim.running._robot_desk import RobotDesk
from xavier_sim.running._robot_module import RobotModule
from xavier_sim.running._robot_state import RobotState
from xavier_sim.running._simulated_time import SimClock
from xavier_sim.snapshots import Saved, SnapshotFile
from xavier_sim.world import World


@dataclass(frozen=True)
class Standing:
    """Whether a robot can go on from a tick, and whether it or somebody on its realm wants to."""

    tick: int
    can: bool
    wants: bool


class Team:
    """The robots of a world; a tick comes when each of them has its command for it.

    In lockstep none hands in its command before all could: so each one's module goes on telling
    its realm the time while it waits for the driver of another.

    Args:
        world: freshly made.
        clock: the time of its ticks.
        speed: simulated seconds per wall second, None for lockstep with all drivers.
    """

    def __init__(self, world: World, clock: SimClock, *, speed: float | None) -> None:
        self.world = world
        self.robots = [
            TeamRobot(self, name, clock, speed=speed, keeps=number == 0)
            for number, name in enumerate(world.robots)
        ]
        self._commands: dict[str, tuple[float, float]] = {}
        self._standings: dict[str, Standing] = {}
        self._ticked = asyncio.Event()

    def restore(self, saved: Saved, *, at_least: float) -> None:
        """Go on from what was kept; see `RobotState.restore`.

        Raises:
            RobotsError: it is of a world with other robots.
        """
        first, *others = self.robots
        first.restore(saved, at_least=at_least)
        for robot in others:
            robot.clock = first.clock
            robot.keep_reflex(saved)

    def note(self, name: str, standing: Standing) -> None:
        """Take in how things stand with a robot; if that is new, the others look again."""
        if self._standings.get(name) != standing:
            self._standings[name] = standing
            self._wake_all_but({name})

    @property
    def may_tick(self) -> bool:
        """Whether all robots could go on from this tick, and one wants to or does already."""
        now = [one for one in self._standings.values() if one.tick == self.world.tick]
        all_can = len(now) == len(self.robots) and all(one.can for one in now)
        return bool(self._commands) or (all_can and any(one.wants for one in now))

    def changed(self) -> None:
        """Let the one who keeps the world know that somebody has changed it."""
        self.robots[0].on_change()

    async def advance(self, name: str, speed: float, turn_rate: float) -> Reading:
        """Hand in the command of a robot, and wait until all have done so."""
        self._commands[name] = (speed, turn_rate)
        if len(self._commands) < len(self.robots):
            await self._wait_for_others()
            return self.world.robots[name].reading
        readings = self.world.step_all(self._commands)
        for robot in self.robots:
            robot.feel()
        self._commands = {}
        self._ticked.set()
        self._ticked = asyncio.Event()
        return readings[name]

    async def _wait_for_others(self) -> None:
        ticked = self._ticked
        self._wake_all_but(self._commands)
        await ticked.wait()

    def _wake_all_but(self, names: Collection[str]) -> None:
        for robot in self.robots:
            if robot.name not in names:
                robot.wake()


async def run_team(
    team: Team,
    store: SnapshotFile | None,
    options: Mapping[str, BusOptions],
    witnesses: Mapping[str, Witness] | None = None,
) -> None:
    """Show each robot to a realm of its own, until cancelled; then keep the world.

    Args:
        team: the robots.
        store: where to keep their world, None for nowhere.
        options: how to join the bus, for each robot by its name.
        witnesses: who records what happens to a robot, by its name.
    """
    async with asyncio.TaskGroup() as group:
        for number, robot in enumerate(team.robots):
            keeper = store if number == 0 else None
            witness = (witnesses or {}).get(robot.name)
            module = RobotModule(robot, keeper, options[robot.name], witness)
            group.create_task(module.run(), name=f"robot {robot.name}")


class TeamRobot(RobotState):
    """One robot of a team; the first keeps the world for all."""

    def __init__(
        self, team: Team, name: str, clock: SimClock, *, speed: float | None, keeps: bool
    ) -> None:
        super().__init__(team.world, clock, speed=speed, name=name)
        self._team, self._keeps = team, keeps
        self.wake: Callable[[], None] = _nothing
        self.on_change: Callable[[], None] = _nothing

    @property
    def must_save(self) -> bool:
        """Whether the next tick may come only after this robot has kept the world."""
        return self._keeps and super().must_save

    async def advance(self, speed: float, turn_rate: float) -> Reading:
        """Drive for a tick, m/s and rad/s, together with the others, and sense."""
        return await self._team.advance(self.name, speed, turn_rate)

    def may_tick(
        self, *, driven: bool, answered: bool, busy: bool, moving: bool, holding: bool
    ) -> bool:
        """Whether time may move by a tick, as far as this robot goes, and the others with it."""
        how = {"driven": driven, "answered": answered, "busy": busy, "holding": holding}
        can = super().may_tick(**how, moving=True)
        wants = super().may_tick(**how, moving=moving)
        self._team.note(self.name, Standing(self.tick, can=can, wants=wants))
        return can and self._team.may_tick

    def reflexes(self) -> dict[str, dict[str, Any]]:
        """The states of all reflexes of the team, by the robot's name."""
        robots = self._team.robots
        return {one.name: one.reflex.snapshot() for one in robots if one.reflex is not None}

    def wake_by(self, wake: Callable[[], None]) -> None:
        """Call this when another robot waits for this one."""
        self.wake = wake

    def open_desk(self, module: Module, outlet: Outlet, changed: Callable[[], None]) -> RobotDesk:
        """Serve what is asked of the robot beside driving."""
        self.on_change = changed
        return super().open_desk(module, outlet, changed if self._keeps else self._team.changed)


def _nothing() -> None:
    """Nobody is there yet to be told."""
