"""The papers' scenarios: what is posted, when, and what is measured on the way."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from navigate.messages import WhereIsRoom
from rogue.messages import ListRequests, PostRequest, RequestState, TraceLine
from rogue.planning import Rules
from tca_bus import Module
from xavier_sim.messages import WhereReally

ARRIVED = "Action NAVIGATE-TO-GOAL-ACHIEVED finished."
VERIFYING = "Verifying Location: "
SENDING = "SENDING COMMAND (TCAEXPANDGOAL"

EPOCH = "1995-10-01T12:51:00"
"""Simulated local time at which the demonstrations start, as in Figure 6."""


@dataclass(frozen=True, slots=True)
class Errand:
    """A request of a scenario; it is posted once a trace line contains ``after``."""

    user: str
    item: str
    pickup: str
    deliver: str
    after: str | None = None


@dataclass(frozen=True, slots=True)
class Scenario:
    """One of the papers' examples."""

    rules: Rules
    errands: tuple[Errand, ...]


_MAIL = Errand("mitchell", "delivermail", "r-5303", "r-5313")

SCENARIOS = {
    "figure6": Scenario(Rules.NONE, (_MAIL,)),
    "figure9": Scenario(
        Rules.Y1996,
        (_MAIL, Errand("jhm", "deliverfax", "r-5311", "r-5313", after=SENDING)),
    ),
}


@dataclass(slots=True)
class Arrival:
    """The robot said to be at a room; how far it really was from the room's place, in metres."""

    room: str
    error: float


@dataclass(slots=True)
class Measurements:
    """What a scenario came to: simulated seconds, metres driven, error at each arrival."""

    begun: float = 0.0
    metres_before: float = 0.0
    seconds: float = 0.0
    metres: float = 0.0
    arrivals: list[Arrival] = field(default_factory=list)

    def line(self) -> str:
        """The last line of a demonstration."""
        errors = ", ".join(f"{one.error:.2f} m at {one.room}" for one in self.arrivals)
        return (
            f"Simulated {self.seconds:.1f} s, driven {self.metres:.1f} m, "
            f"position error {errors or 'not measured'}."
        )


class Observer:
    """Measures while the trace goes by, with the simulator's word for the truth."""

    def __init__(self, module: Module) -> None:
        self._module = module
        self.measured = Measurements()

    async def begin(self) -> None:
        """Note where it starts."""
        truth = await self._module.query(WhereReally())
        self.measured.begun, self.measured.metres_before = truth.time, truth.metres

    async def see(self, line: TraceLine) -> None:
        """Measure at each arrival: the robot stands while it asks."""
        if VERIFYING in line.text:
            room = line.text.rsplit(" ", 1)[-1].lower()
            truth = await self._module.query(WhereReally())
            place = await self._module.query(WhereIsRoom(room=room))
            error = math.hypot(truth.x - place.x / 100.0, truth.y - place.y / 100.0)
            self.measured.arrivals.append(Arrival(room, error))

    async def end(self) -> Measurements:
        """Note where it ends."""
        truth = await self._module.query(WhereReally())
        self.measured.seconds = truth.time - self.measured.begun
        self.measured.metres = truth.metres - self.measured.metres_before
        return self.measured


class Poster:
    """Posts the errands of a scenario when their time has come."""

    def __init__(self, module: Module, scenario: Scenario) -> None:
        self._module = module
        self._left = list(scenario.errands)
        self._posted: list[str] = []

    async def begin(self) -> None:
        """Post what is there from the start."""
        await self._post([errand for errand in self._left if errand.after is None])

    async def see(self, line: TraceLine) -> None:
        """Post what was to come after a line like this."""
        await self._post([e for e in self._left if e.after is not None and e.after in line.text])

    @property
    def all_posted(self) -> bool:
        """Whether nothing is left to post."""
        return not self._left

    async def failures(self) -> list[str]:
        """What went wrong with the posted requests, in sentences."""
        found = await self._module.query(ListRequests())
        wrong = [r for r in found if r.state is not RequestState.COMPLETED]
        return [f"request {r.id} is {r.state.value}: {r.reason}" for r in wrong]

    async def _post(self, errands: list[Errand]) -> None:
        for errand in errands:
            self._left.remove(errand)
            await self._module.query(
                PostRequest(
                    id=f"{errand.user}-{errand.item}",
                    user=errand.user,
                    item=errand.item,
                    pickup=errand.pickup,
                    deliver=errand.deliver,
                )
            )
