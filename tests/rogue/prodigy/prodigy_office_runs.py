"""Runs of ROGUE's office for the tests: a world that does what is asked, or not."""

from __future__ import annotations

import random
from collections.abc import Callable

from rogue.errands import Errand, Switches, load_office_domain, load_office_problem
from rogue.prodigy import Execute, Literal, Problem, Search, StepView

DOMAIN = load_office_domain()
FIGURE6 = load_office_problem("figure6", DOMAIN)
JHM = Errand("jhm", "deliverfax", "r-5311", "r-5313")
MITCHELL = Errand("mitchell", "delivermail", "r-5303", "r-5313")

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
    return Search(FIGURE6, switches.options, switches.rules)


def arrives_during_first_step(errand: Errand) -> Outcome:
    pending = [errand]

    def outcome(search: Search, _step: StepView) -> None:
        if pending:
            one = pending.pop()
            search.add_goal(one.facts(), one.goal())

    return outcome


def wrong_room_first(room: str) -> Outcome:
    first = [True]

    def outcome(_search: Search, _step: StepView) -> tuple[list[Literal], list[Literal]] | None:
        return ([at(room)], [at("r-5301")]) if first and first.pop() else None

    return outcome


def random_batch(count: int, rooms: int, seed: int) -> tuple[Problem, Callable[[str, str], float]]:
    """Deliveries between distinct random rooms on a ring, 3 m apart."""
    chance = random.Random(seed)
    names = [f"r-{i}" for i in range(rooms)]
    errands = []
    for i in range(count):
        pickup, deliver = chance.sample(names, 2)
        errands.append(Errand(f"user{i}", f"item{i}", pickup, deliver))
    problem = Problem.build(
        DOMAIN,
        objects={
            "room": names,
            "person": [e.user for e in errands],
            "item": [e.item for e in errands],
        },
        facts=[at(chance.choice(names)), *(f for e in errands for f in e.facts())],
        goals=[e.goal() for e in errands],
    )

    def ring(one: str, other: str) -> float:
        apart = (int(one[2:]) - int(other[2:])) % rooms
        return 3.0 * min(apart, rooms - apart)

    return problem, ring
