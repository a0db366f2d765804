"""The navigator in a loop with the simulated world, in this process."""

from __future__ import annotations

import math
from collections.abc import Callable

from navigate.driving import Drive
from navigate.maps import Floor, load_plan
from navigate.navigator import Navigator
from xavier_sim.floors import load_floor
from xavier_sim.messages import Corner, FloorPlan, Space, SpaceKind
from xavier_sim.profile import XAVIER, RobotProfile
from xavier_sim.running import RobotState, SimClock
from xavier_sim.world import World

EPOCH = 1.0e9


def true_plan() -> FloorPlan:
    return load_floor("wean5")


class Loop:
    """A world and a navigator that drives in it."""

    def __init__(
        self,
        seed: int = 0,
        plan: FloorPlan | None = None,
        *,
        people: int = 0,
        profile: RobotProfile = XAVIER,
    ) -> None:
        self.world = World(plan or true_plan(), seed, profile, people=people)
        self.robot = RobotState(self.world, SimClock(EPOCH), speed=None)
        self.navigator = Navigator(Floor(load_plan()), seed=seed)
        self.sensors = self.robot.sensors()
        self.navigator.step(self.sensors)

    def tick(self) -> None:
        wheels = self.navigator.wheels
        self.world.step(wheels.speed, wheels.turn)
        self.sensors = self.robot.sensors()
        self.navigator.step(self.sensors)

    def rest(self, ticks: int) -> None:
        for _ in range(ticks):
            self.tick()

    def start(self, room: str) -> Drive:
        return self.navigator.start(self.navigator.floor.place(room), self.sensors)

    def drive(
        self, room: str, *, most: int = 4000, each: Callable[[], object] = lambda: None
    ) -> Drive:
        drive = self.start(room)
        for _ in range(most):
            if drive.done:
                return drive
            self.tick()
            each()
        raise AssertionError(f"still on the way to {room} after {most} ticks: {drive.troubles}")

    def off(self, room: str) -> float:
        """Metres from the true place of a room."""
        place, truth = self.world.plan.places[room], self.world.truth()
        return math.dist((place.x, place.y), (truth.x, truth.y))

    def astray(self) -> float:
        """Metres between belief and truth."""
        here, truth = self.navigator.position(), self.world.truth()
        return math.dist((here.x, here.y), (truth.x, truth.y))


def with_box(plan: FloorPlan, low: tuple[float, float], high: tuple[float, float]) -> FloorPlan:
    """The plan with a box on the floor that no map knows."""
    box = Space(
        name="box",
        kind=SpaceKind.ROOM,
        low=Corner(x=low[0], y=low[1]),
        high=Corner(x=high[0], y=high[1]),
    )
    return plan.model_copy(update={"spaces": (*plan.spaces, box)})
