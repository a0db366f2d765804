"""What the agent tells the planner: the office as a problem, requests as goals.

Source: Haigh & Veloso (1996), Figure 7.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Literal

from rogue.errands import (
    Agenda,
    Claim,
    Errand,
    Switches,
    example1998,
    figure6,
    figure9,
    working,
)
from rogue.memory import Facts
from rogue.messages import DeliveryRequest
from rogue.outcomes import StepOutcome
from rogue.prodigy import Literal as Fact
from rogue.prodigy import Search
from rogue.requests import Directory

NODES_OF_A_SEARCH = 1000
"""Nodes after which a search that has executed something gives way to a fresh one."""

NODES_OF_A_REQUEST = 200
"""Nodes that each request may cost before the planner gives up: ten times what it should."""


class Rules(enum.StrEnum):
    """The rule sets of the office: those of the published runs, and the working one."""

    NONE = "none"
    """PRODIGY's defaults only: Figure 6."""
    Y1996 = "1996"
    """The nearest room first, requests enter at the end of a cycle: Figure 9."""
    Y1998 = "1998"
    """Operators by their consumer, requests enter before the next decision."""
    WORKING = "working"
    """The domain and the rules with which the agent works."""

    @property
    def one_errand_a_person(self) -> bool:
        """Whether a person's second errand has to wait for the first.

        In the published domain a room is tied to a person and not to an item.
        """
        return self is not Rules.WORKING


RuleName = Literal["none", "1996", "1998", "working"]
"""A rule set as it is named on the command line."""


def switches(rules: Rules, agenda: Agenda) -> Switches:
    """Domain, options and control rules of a rule set, for one search."""
    match rules:
        case Rules.NONE:
            return figure6()
        case Rules.Y1996:
            return figure9(agenda.travel.distance)
        case Rules.Y1998:
            return example1998(agenda.travel.distance)
        case Rules.WORKING:
            return working(agenda)


def errand(request: DeliveryRequest) -> Errand:
    """A request as the planner knows it: the item may have to go back where it came from."""
    back = request.then == "back"
    return Errand(request.user, request.item, request.pickup, request.destination, back=back)


def claim(request: DeliveryRequest, directory: Directory) -> Claim:
    """A request as the metric of priorities is told of it.

    What is only to be brought back has no deadline any more.
    """
    person, item = directory.people.get(request.user), directory.items.get(request.item)
    return Claim(
        user=request.user,
        item=request.item,
        person_rank=person.rank if person else 0,
        task_rank=item.rank if item else 0,
        posted=request.posted,
        deadline=request.deadline if request.closing is None else math.inf,
    )


def in_room(room: str) -> Fact:
    """That the robot is in a room."""
    return Fact("robot-in-room", (room,))


def new_search(
    requests: Sequence[DeliveryRequest],
    facts: Facts,
    *,
    directory: Directory,
    rooms: Iterable[str],
    switches: Switches,
    level: int = 2,
) -> Search:
    """A search for the requests from what is known of the world; ``level`` is that of its trace."""
    problem = switches.problem(
        [errand(request) for request in requests],
        rooms=rooms,
        people={*directory.people, *(request.user for request in requests)},
        items={*directory.items, *(request.item for request in requests)},
        at=facts.room,
        carried=facts.tray,
    )
    most = 10 * NODES_OF_A_SEARCH + NODES_OF_A_REQUEST * len(requests)
    options = replace(switches.options, max_nodes=most, level=level)
    return Search(problem, options, switches.rules)


def report(search: Search, outcome: StepOutcome, facts: Facts, switches: Switches) -> None:
    """Tell the search what came of an operator; ``facts`` are those after it."""
    if outcome.kind == "done":
        search.executed()
    else:
        added, deleted = _corrections(search, facts, switches)
        search.executed(added=added, deleted=deleted)


def correct(search: Search, facts: Facts, switches: Switches) -> None:
    """Bring the search's state in line with what is known of robot and tray."""
    added, deleted = _corrections(search, facts, switches)
    if added:
        search.assert_facts(*added)
    if deleted:
        search.retract_facts(*deleted)


def _corrections(search: Search, facts: Facts, switches: Switches) -> tuple[list[Fact], list[Fact]]:
    """What is so and the search does not know, and what it believes and is not so."""
    known = {Fact("robot-has-item", thing) for thing in facts.tray}
    known.update(switches.tray(len(facts.tray)))
    if facts.room is not None:
        known.add(in_room(facts.room))
    believed = {
        Fact(predicate, args)
        for predicate in ("robot-in-room", "robot-has-item", "places-left", "tray-full")
        for args in search.state.tuples(predicate)
    }
    return sorted(known - believed), sorted(believed - known)


def admit(
    search: Search,
    request: DeliveryRequest,
    others: Iterable[DeliveryRequest],
    switches: Switches,
) -> None:
    """Add a request to a running search.

    An errand that was done in this search before is to be done once more, perhaps in other
    rooms, so its goal must not count as reached.
    """
    own = errand(request)
    for name, kind in ((own.user, "person"), (own.item, "item")):
        if name not in search.objects:
            search.add_object(name, kind)
    goal = switches.goal(own)
    if goal in search.goals:
        withdraw(search, request, others, switches)
    left_over = switches.rooms_of(own, search.state)
    if search.state.holds(goal):
        left_over.append(goal)
    search.retract_facts(*left_over)
    search.add_goal(switches.facts(own), goal)


def withdraw(
    search: Search,
    request: DeliveryRequest,
    others: Iterable[DeliveryRequest],
    switches: Switches,
) -> None:
    """Drop a request from the search, but not facts that other requests share with it."""
    own = errand(request)
    shared = {fact for other in others for fact in switches.facts(errand(other))}
    gone = [fact for fact in switches.facts(own) if fact not in shared]
    search.remove_goal(switches.goal(own), gone)
