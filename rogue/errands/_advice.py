"""What the working domain's control rules ask: meta-predicates over search and agenda."""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass

from rogue.errands._agenda import GOALS, Agenda, key_of, robot_room, thing_of
from rogue.errands._selection import Selected, select
from rogue.errands._tour import EMPTY, OpenErrand, Stop, Tour
from rogue.errands._touring import best_tour
from rogue.prodigy import Instance, Literal, MetaPredicate, SearchView

ACQUIRE, DELIVER, RETURN = "acquire-item", "deliver-item", "return-item"
PICKUP_GOTO, DELIVER_GOTO = "goto-pickup-loc", "goto-deliver-loc"
CONSUMERS = {PICKUP_GOTO: (ACQUIRE,), DELIVER_GOTO: (DELIVER, RETURN)}
"""The operators for whose sake each GOTO is chosen."""


AT_ONCE = 3
"""Errands that are planned before the robot sets out, though it could."""


@dataclass(frozen=True, slots=True)
class Outlook:
    """What is so at one decision: robot, open errands, those that are served, and in what order."""

    here: str | None
    errands: tuple[OpenErrand, ...]
    selected: Selected
    tour: Tour

    @property
    def all_are_top(self) -> bool:
        """Whether no errand is put off, nor served only because it is on the way."""
        return len(self.selected.top) == len(self.errands)

    @property
    def put_aside(self) -> frozenset[tuple[str, str]]:
        """User and item of the errands that are open and not served now."""
        return frozenset(thing_of(e.key) for e in self.errands if e.key not in self.selected)


class Advice:
    """Answers to the meta-predicates; one for each search.

    Attributes:
        agenda: What they know besides the search.
        latest: What was so at the last decision.
    """

    def __init__(self, agenda: Agenda) -> None:
        self.agenda = agenda
        self._asked: SearchView | None = None
        self._question: tuple[object, ...] = ()
        self.latest = Outlook(None, (), Selected(), EMPTY)
        self._next: frozenset[int] = frozenset()

    def meta_predicates(self) -> Mapping[str, MetaPredicate]:
        """The meta-predicates by the names that the domain has for them."""
        return {
            "is-needed-by": self.is_needed_by,
            "is-for-consumer": self.is_for_consumer,
            "is-delivery-planned": self.is_delivery_planned,
            "ancestor-is-top-priority-goal": self.ancestor_is_top_priority_goal,
            "compatible-with-top-priority-goal": self.compatible_with_top_priority_goal,
            "is-much-left-to-plan": self.is_much_left_to_plan,
            "is-for-next-stop": self.is_for_next_stop,
            "is-next-stop-ready": self.is_next_stop_ready,
            "is-served-now": self.is_served_now,
            "is-premature-goto": self.is_premature_goto,
            "is-next-of-tour": self.is_next_of_tour,
        }

    def is_needed_by(self, view: SearchView, room: str, operator: str) -> bool:
        """Whether a planned operator needs the robot to be in a room."""
        consumers = view.consumers(Literal("robot-in-room", (room,)))
        return any(c.name == operator for c in consumers)

    def is_for_consumer(self, view: SearchView, goto: Instance) -> bool:
        """Whether an operator that needs the GOTO's room is for the same user and item."""
        if goto.name not in CONSUMERS:
            return True
        consumers = view.consumers(Literal("robot-in-room", (_room(goto),)))
        own = [c for c in consumers if c.name in CONSUMERS[goto.name]]
        return not own or any(_errand(c) == _errand(goto) for c in own)

    def is_delivery_planned(self, view: SearchView) -> bool:
        """Whether something that is on the tray will leave it by what is planned."""
        carried = view.state.tuples("robot-has-item")
        return any(
            c.name in CONSUMERS[DELIVER_GOTO] and (c.value("user"), c.value("item")) in carried
            for c in view.tail()
        )

    def ancestor_is_top_priority_goal(self, view: SearchView, goal: Literal) -> bool:
        """Whether a goal is one of the most urgent errands, or needed for it."""
        outlook = self.outlook(view)
        return outlook.all_are_top or _is_for(view, goal, outlook.selected.top)

    def compatible_with_top_priority_goal(self, view: SearchView, goal: Literal) -> bool:
        """Whether a goal is needed for an errand that lies on the way of the most urgent ones."""
        return _is_for(view, goal, self.outlook(view).selected.compatible)

    def is_much_left_to_plan(self, view: SearchView) -> bool:
        """Whether more errands than `AT_ONCE` are not planned yet."""
        return sum(goal.predicate in GOALS for goal in view.pending_goals()) > AT_ONCE

    def is_for_next_stop(self, view: SearchView, goal: Literal) -> bool:
        """Whether a goal is needed for the errand of the tour's next stop."""
        stops = self.outlook(view).tour.stops
        return bool(stops) and _is_for(view, goal, {stops[0].key})

    def is_next_stop_ready(self, view: SearchView) -> bool:
        """Whether something that can be done now leads to the tour's next stop."""
        outlook = self.outlook(view)
        stops = outlook.tour.stops
        return bool(stops) and any(_leads_to(op, stops[0], outlook.here) for op in view.ready())

    def is_served_now(self, view: SearchView, operator: Instance) -> bool:
        """Whether an operator is for an errand that is not put off."""
        outlook = self.outlook(view)
        return outlook.all_are_top or _is_for(view, operator, outlook.selected)

    def is_premature_goto(self, view: SearchView, operator: Instance) -> bool:
        """Whether all that need the GOTO's room lack more than being there."""
        if operator.name not in CONSUMERS or operator.goal is None:
            return False
        consumers = view.consumers(operator.goal)
        return all(view.lacking(c) != (operator.goal,) for c in consumers)

    def is_next_of_tour(self, view: SearchView, operator: Instance) -> bool:
        """Whether an operator leads to the next stop of the tour; true of all if none does."""
        self.outlook(view)
        return not self._next or operator.node in self._next

    def outlook(self, view: SearchView) -> Outlook:
        """What is so at the decision that a view shows."""
        if view is not self._asked:
            self._asked = view
            self._look(view)
            self._next = self._next_of_tour(view)
        return self.latest

    def _look(self, view: SearchView) -> None:
        agenda, here = self.agenda, robot_room(view)
        errands = agenda.errands(view)
        travel = agenda.travel_beside(view, errands)
        now = agenda.moment()
        question = (here, errands, travel.capacity, now)
        if question == self._question:
            return
        selected = select(
            errands,
            start=here,
            travel=travel,
            nearby=agenda.nearby,
            margin=agenda.margin,
            now=now,
        )
        served = [e for e in errands if e.key in selected]
        beside = agenda.travel_beside(view, served)
        tour = best_tour(served, start=here, travel=beside, now=now)
        self._question, self.latest = question, Outlook(here, errands, selected, tour)

    def _next_of_tour(self, view: SearchView) -> frozenset[int]:
        """Nodes of the ready operators that lead to the first stop to which any does."""
        ready, here = view.ready(), self.latest.here
        for stop in self.latest.tour.stops:
            found = frozenset(op.node for op in ready if _leads_to(op, stop, here))
            if found:
                return found
        return frozenset()


def _is_for(view: SearchView, it: Literal | Instance, keys: Container[str]) -> bool:
    return any(key_of(*goal.args) in keys for goal in view.top_level_goals(it))


def _leads_to(operator: Instance, stop: Stop, here: str | None) -> bool:
    if operator.name in CONSUMERS:
        return stop.room == _room(operator) != here
    if key_of(*_errand(operator)) != stop.key:
        return False
    return stop.is_delivery == (operator.name != ACQUIRE)


def _errand(operator: Instance) -> tuple[object, object]:
    return operator.value("user"), operator.value("item")


def _room(operator: Instance) -> str:
    return str(operator.value("room"))
