"""An office where much goes wrong: what is asked for is done all the same."""

from __future__ import annotations

import random
from dataclasses import dataclass, field

import pytest
from prodigy_office_runs import at, metres, plain

from rogue.errands import Agenda, Errand, Switches, Travel, example1998, figure9, working
from rogue.prodigy import Execute, Literal, Poll, Search, Status, StepView

ROOMS = [f"r-{5300 + i}" for i in range(1, 30, 2)]
PEOPLE = [f"user{i}" for i in range(4)]
ITEMS = [f"item{i}" for i in range(3)]


@dataclass
class Office:
    """The truth about the world; steps fail by chance, requests come and go."""

    chance: random.Random
    switches: Switches
    room: str = ROOMS[0]
    tray: set[tuple[str, str]] = field(default_factory=set)
    open: dict[tuple[str, str], Errand] = field(default_factory=dict)
    delivered: set[tuple[str, str]] = field(default_factory=set)
    dropped: set[tuple[str, str]] = field(default_factory=set)
    posted: int = 0

    @property
    def places(self) -> int | None:
        advice = self.switches.advice
        return advice.agenda.travel.capacity if advice else None

    def perform(self, step: StepView) -> tuple[list[Literal], list[Literal]] | None:
        if step.operator.startswith("goto"):
            return self._go(str(step.args[1]))
        room, user, item = map(str, step.args)
        assert room == self.room, "nothing is taken or given away from its door"
        if self.chance.random() < 0.2:
            return [], []
        errand = self.open[user, item]
        if step.operator == "acquire-item":
            assert room == errand.pickup
            assert (user, item) not in self.tray, "nothing is taken twice"
            self.tray.add((user, item))
            assert self.places is None or len(self.tray) <= self.places
        else:
            assert room == errand.deliver
            self.tray.remove((user, item))
            self.delivered.add((user, item))
        return None

    def _go(self, target: str) -> tuple[list[Literal], list[Literal]] | None:
        before = self.room
        self.room = target if self.chance.random() > 0.3 else self.chance.choice(ROOMS)
        if self.room == target:
            return None
        return ([], []) if self.room == before else ([at(self.room)], [at(before)])

    def maybe_post(self, search: Search) -> None:
        if self.posted >= 8 or self.chance.random() > 0.2:
            return
        user, item = self.chance.choice(PEOPLE), self.chance.choice(ITEMS)
        known = {key[0] for key in self.open} if self.switches.is_published else set()
        if (user, item) in self.open or user in known:
            return
        errand = Errand(user, item, *self.chance.sample(ROOMS, 2))
        self.open[user, item] = errand
        self.posted += 1
        search.add_goal(self.switches.facts(errand), self.switches.goal(errand))

    def maybe_drop(self, search: Search) -> None:
        waiting = [k for k in self.open if k not in self.tray | self.delivered | self.dropped]
        if not waiting or self.chance.random() > 0.05:
            return
        key = self.chance.choice(waiting)
        others = [e for k, e in self.open.items() if k != key and k not in self.dropped]
        shared = {fact for other in others for fact in self.switches.facts(other)}
        errand = self.open[key]
        self.dropped.add(key)
        gone = [fact for fact in self.switches.facts(errand) if fact not in shared]
        search.remove_goal(self.switches.goal(errand), gone)


def live_through(office: Office, search: Search) -> None:
    for event in search.events():
        if isinstance(event, Execute):
            office.maybe_post(search)
            changed = office.perform(event.step)
            if changed is None:
                search.executed()
            else:
                search.executed(added=changed[0], deleted=changed[1])
        elif isinstance(event, Poll):
            office.maybe_post(search)
            office.maybe_drop(search)


def first_errand() -> Errand:
    return Errand("user0", "item0", ROOMS[3], ROOMS[9])


WAYS = {
    "working": plain(metres),
    "tray of two": working(Agenda(travel=Travel(distance=metres, capacity=2))),
    "1998": example1998(metres),
    "1996": figure9(metres),
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(12))
def test_everything_that_is_not_dropped_is_delivered(way: str, seed: int) -> None:
    switches = WAYS[way]
    office = Office(random.Random(seed), switches)
    office.open["user0", "item0"] = first_errand()
    problem = switches.problem(
        [first_errand()], rooms=ROOMS, people=PEOPLE, items=ITEMS, at=ROOMS[0]
    )
    search = Search(problem, switches.options, switches.rules)
    live_through(office, search)
    assert search.result is not None
    assert search.result.status is Status.SOLVED, search.result.reason
    assert set(office.open) == office.delivered | office.dropped
