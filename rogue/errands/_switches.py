"""What distinguishes the published examples from one another, and from how the agent works."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from importlib import resources

from rogue.errands._advice import Advice
from rogue.errands._agenda import Agenda
from rogue.errands._errand import Errand
from rogue.errands._published_rules import goto_for_consumer_rule, nearest_room_rule
from rogue.errands._tour import Distance
from rogue.errands._tray import tray_counts, tray_facts, tray_state
from rogue.prodigy import (
    Domain,
    Literal,
    PollPoint,
    Problem,
    RuleSet,
    SearchOptions,
    State,
    parse_domain,
    parse_problem,
)


@dataclass(frozen=True, slots=True)
class Switches:
    """A way of planning: a domain, the options of the search, and rules besides the domain's.

    Attributes:
        domain: What can be done.
        options: Mode, limits, when requests enter.
        rules: Control rules, defined after those of the domain.
        advice: What the domain's rules ask; None for the published domain.
    """

    domain: Domain
    options: SearchOptions
    rules: RuleSet = field(default_factory=RuleSet)
    advice: Advice | None = None

    @property
    def is_published(self) -> bool:
        """Whether rooms belong to a person only, who can then have but one errand at a time."""
        return self.advice is None

    def facts(self, errand: Errand) -> tuple[Literal, ...]:
        """What the search is told with an errand, as in Figure 7."""
        thing = (errand.user, errand.item)
        needed = Literal("needs-item", thing)
        if self.is_published:
            return (
                needed,
                Literal("pickup-loc", (errand.user, errand.pickup)),
                Literal("deliver-loc", (errand.user, errand.deliver)),
            )
        bound_for = Literal("bound-for", (*thing, errand.deliver))
        if errand.back:
            return (bound_for,)
        return (needed, Literal("item-at", (*thing, errand.pickup)), bound_for)

    def rooms_of(self, errand: Errand, state: State) -> list[Literal]:
        """The rooms that a state has for user and item of an errand."""
        if self.is_published:
            return []
        thing = (errand.user, errand.item)
        return [
            Literal(predicate, args)
            for predicate in ("item-at", "bound-for")
            for args in sorted(state.tuples(predicate))
            if args[:2] == thing
        ]

    def goal(self, errand: Errand) -> Literal:
        """The goal of an errand: that its user has the item, or that it is back.

        In the published domain an item is brought back as it is delivered.
        """
        is_back = errand.back and not self.is_published
        return Literal("item-returned" if is_back else "has-item", (errand.user, errand.item))

    def tray(self, carried: int) -> tuple[Literal, ...]:
        """What changes with the number of items on the tray."""
        return tuple(tray_state(self._places, carried))

    def problem(
        self,
        errands: Sequence[Errand],
        *,
        rooms: Iterable[str],
        people: Iterable[str],
        items: Iterable[str],
        at: str | None = None,
        carried: Collection[tuple[str, str]] = (),
    ) -> Problem:
        """The office as a problem.

        Args:
            errands: What is to be done; more may come.
            rooms: All rooms.
            people: All who may want something.
            items: All that may be carried.
            at: Room of the robot, None if nobody knows where it is.
            carried: User and item of what is on the tray.
        """
        facts = [fact for errand in errands for fact in self.facts(errand)]
        facts += [Literal("robot-has-item", thing) for thing in sorted(carried)]
        facts += [Literal("robot-in-room", (at,))] if at is not None else []
        facts += tray_facts(self._places, len(carried))
        objects = {"room": sorted(rooms), "person": sorted(people), "item": sorted(items)}
        if not self.is_published:
            objects["count"] = list(tray_counts(self._places))
        goals = [self.goal(errand) for errand in errands]
        return Problem.build(self.domain, objects=objects, facts=facts, goals=goals, name="office")

    @property
    def _places(self) -> int | None:
        return self.advice.agenda.travel.capacity if self.advice else None


_AT_END = SearchOptions(
    execute=True, depth_bound=None, max_nodes=None, time_limit=None, proof_states=0
)
_EARLY = replace(_AT_END, poll=PollPoint.BEFORE_EXPANSION)


def figure6() -> Switches:
    """Return the switches of Figure 6: SABA, no rules, executing, polled at the end of a cycle."""
    return Switches(load_office_domain(), _AT_END)


def figure9(distance: Distance) -> Switches:
    """Return the switches of Figure 9: those of Figure 6 and the nearest-room rule."""
    return Switches(load_office_domain(), _AT_END, RuleSet((nearest_room_rule(distance),)))


def example1998(distance: Distance) -> Switches:
    """Return those of the 1998 example: operators by consumer, nearest room, earlier poll."""
    rules = (goto_for_consumer_rule(), nearest_room_rule(distance))
    return Switches(load_office_domain(), _EARLY, RuleSet(rules))


def working(agenda: Agenda) -> Switches:
    """Return how the agent works: the working domain, whose text has its rules.

    They are for one search, and ask the agenda, which may change while the search runs. Rules
    that a program adds are asked before them.
    """
    advice = Advice(agenda)
    # Priorities change while the robot drives, and it may have to turn back with nothing done.
    options = replace(_EARLY, revisit=True)
    return Switches(load_working_domain(advice), options, advice=advice)


@lru_cache(maxsize=1)
def load_office_domain() -> Domain:
    """Return ROGUE's domain as published, ``domains/office.pdl``."""
    return parse_domain(_text("office.pdl"), file="office.pdl")


def load_working_domain(advice: Advice) -> Domain:
    """Return the domain with which the agent works, ``domains/working.pdl``, for one search."""
    asked = advice.meta_predicates()
    return parse_domain(_text("working.pdl"), file="working.pdl", meta_predicates=asked)


def load_office_problem(name: str, domain: Domain) -> Problem:
    """Return one of the problems beside the published domain, such as ``figure6``."""
    return parse_problem(_text(f"{name}.pdl"), domain, file=f"{name}.pdl")


def _text(name: str) -> str:
    return resources.files("rogue.errands").joinpath("domains", name).read_text("utf-8")
