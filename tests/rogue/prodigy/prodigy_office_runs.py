"""Runs of ROGUE's office for the tests: a world that does what is asked, or not."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass

from rogue.errands import (
    Agenda,
    Errand,
    Switches,
    figure6,
    load_office_domain,
    load_office_problem,
    working,
)
from rogue.prodigy import Execute, Literal, RuleSet, Search, StepView

DOMAIN = load_office_domain()
FIGURE6 = load_office_problem("figure6", DOMAIN)
PUBLISHED = figure6()
JHM = Errand("jhm", "deliverfax", "r-5311", "r-5313")
MITCHELL = Errand("mitchell", "delivermail", "r-5303", "r-5313")
ROOMS = FIGURE6.objects.names()
PEOPLE, ITEMS = ["mitchell", "jhm"], ["delivermail", "deliverfax"]

Outcome = Callable[[Search, StepView], tuple[list[Literal], list[Literal]] | None]


def metres(one: str, other: str) -> float:
    """Rooms of one side stand 3.6 m apart."""
    return abs(int(one[2:]) - int(other[2:])) * 1.8


def at(room: str) -> Literal:
    return Literal("robot-in-room", (room,))


def shown(steps: tuple[StepView, ...]) -> list[str]:
    return [" ".join(map(str, (step.operator, *step.args))) for step in steps]


def run(search: Search, *, outcome: Outcome | None = None) -> Search:
    """Execute to the end; ``outcome`` gives what a step really changed, None as predicted."""
    for event in search.events():
        if isinstance(event, Execute):
            changed = outcome(search, event.step) if outcome else None
            if changed is None:
                search.executed()
            else:
                search.executed(added=changed[0], deleted=changed[1])
    return search


def figure6_search(switches: Switches) -> Search:
    problem = FIGURE6
    if not switches.is_published:
        problem = switches.problem([MITCHELL], rooms=ROOMS, people=PEOPLE, items=ITEMS, at="r-5301")
    return Search(problem, switches.options, switches.rules)


def arrives_during_first_step(errand: Errand) -> Outcome:
    pending = [errand]

    def outcome(search: Search, _step: StepView) -> None:
        if pending:
            one = pending.pop()
            search.add_goal(PUBLISHED.facts(one), PUBLISHED.goal(one))

    return outcome


def wrong_room_first(room: str) -> Outcome:
    first = [True]

    def outcome(_search: Search, _step: StepView) -> tuple[list[Literal], list[Literal]] | None:
        return ([at(room)], [at("r-5301")]) if first and first.pop() else None

    return outcome


@dataclass(frozen=True)
class Batch:
    """Deliveries between distinct random rooms on a ring, 3 m apart."""

    errands: list[Errand]
    rooms: list[str]
    start: str

    def metres(self, one: str, other: str) -> float:
        apart = (int(one[2:]) - int(other[2:])) % len(self.rooms)
        return 3.0 * min(apart, len(self.rooms) - apart)

    def search(self, switches: Switches, rules: RuleSet | None = None) -> Search:
        problem = switches.problem(
            self.errands,
            rooms=self.rooms,
            people=[e.user for e in self.errands],
            items=[e.item for e in self.errands],
            at=self.start,
        )
        return Search(problem, switches.options, switches.rules + (rules or RuleSet()))


def random_batch(count: int, rooms: int, seed: int) -> Batch:
    chance = random.Random(seed)
    names = [f"r-{i}" for i in range(rooms)]
    errands = [Errand(f"user{i}", f"item{i}", *chance.sample(names, 2)) for i in range(count)]
    return Batch(errands, names, chance.choice(names))


def plain(distance: Callable[[str, str], float]) -> Switches:
    """How the agent works, all errands being alike."""
    return working(Agenda.plain(distance))
