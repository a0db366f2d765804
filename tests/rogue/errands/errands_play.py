"""Searches over errands, played with scripted outcomes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from rogue.errands import Agenda, Claim, Errand, Switches, Travel, working
from rogue.prodigy import Execute, Literal, Search, Status, StepView

Changed = tuple[list[Literal], list[Literal]] | None
"""What a step really changed; None as predicted."""


def corridor(one: str, other: str) -> float:
    """Rooms stand 1.8 m apart for each number, other wings behind r-5301; a floor costs 60 m."""
    floors = abs(int(one[2]) - int(other[2]))
    return abs(place(one) - place(other)) + 60.0 * floors


def place(room: str) -> float:
    """Metres along the corridor."""
    number = int(room[4:])
    return 1.8 * number if room[2:4] == "53" else -1.8 * number


@dataclass
class Play:
    """One search; ``at_step`` gives what happens while the n-th step is carried out, from 1."""

    places: int | None = None
    nearby: float = 12.0
    now: float = 0.0
    agenda: Agenda | None = None
    switches: Switches = field(init=False)
    search: Search = field(init=False)
    at_step: dict[int, Callable[[], Changed]] = field(default_factory=dict)
    performed: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        if self.agenda is None:
            travel = Travel(distance=corridor, capacity=self.places)
            self.agenda = Agenda(travel=travel, nearby=self.nearby, now=lambda: self.now)
        self.switches = working(self.agenda)

    def begin(
        self,
        errands: Iterable[Errand],
        rooms: Iterable[str],
        at: str = "r-5301",
        carried: Iterable[tuple[str, str]] = (),
    ) -> None:
        problem = self.switches.problem(
            list(errands),
            rooms=rooms,
            people=["mitchell", "jhm", "newell"],
            items=["delivermail", "deliverfax", "parcel"],
            at=at,
            carried=list(carried),
        )
        self.search = Search(problem, self.switches.options, self.switches.rules)

    def claim(
        self, errand: Errand, rank: float, deadline: float = float("inf"), *, posted: float = 0.0
    ) -> Errand:
        claim = Claim(
            user=errand.user,
            item=errand.item,
            person_rank=rank,
            posted=posted,
            deadline=deadline,
        )
        self.agenda.put(claim)
        return errand

    def arrive(self, errand: Errand) -> None:
        self.search.add_goal(self.switches.facts(errand), self.switches.goal(errand))

    def withdraw(self, errand: Errand) -> None:
        self.search.remove_goal(self.switches.goal(errand), self.switches.facts(errand))

    def next_step(self) -> StepView | None:
        """The next step that is to be executed; None where the search has ended."""
        events = (e for e in self.search.events() if isinstance(e, Execute))
        event = next(events, None)
        return event.step if event else None

    def run(self) -> list[str]:
        for event in self.search.events():
            if isinstance(event, Execute):
                self._perform(event.step)
        assert self.search.result is not None
        assert self.search.result.status is Status.SOLVED, self.search.result.reason
        return self.performed

    def _perform(self, step: StepView) -> None:
        self.performed.append(" ".join(map(str, (step.operator, *step.args))))
        event = self.at_step.get(len(self.performed))
        changed = event() if event else None
        if changed is None:
            self.search.executed()
        else:
            self.search.executed(added=changed[0], deleted=changed[1])
