"""The search."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rogue.prodigy._events import Event, NodeView, StepView
from rogue.prodigy._options import SearchOptions
from rogue.prodigy._problem import Problem
from rogue.prodigy._result import SearchResult
from rogue.prodigy._rules import RuleSet
from rogue.prodigy._state import State
from rogue.prodigy._terms import Literal


class Search:
    """One search, driven by its caller one event at a time.

    ``step`` goes on to the next event. At an ``Execute`` event the caller performs the action and
    calls ``executed``; at any time, but with effect at the next poll, it may change goals,
    objects and facts (with ``PollPoint.BEFORE_EXPANSION`` changes made during an execution show
    in the lists at once)::

        search = Search(problem, options, rules)
        while (event := search.step()) is not None:
            match event:
                case Execute(step=step):
                    outcome = await perform(step)
                    search.executed(added=outcome.added, deleted=outcome.deleted)
                case Poll():
                    for request in arrived():
                        search.add_goal(request.facts, request.goal)
                case Finished(result=result):
                    ...

    Args:
        problem: What to solve; its goal may be empty and goals be added at the first poll.
        options: Mode, limits, whether to execute, where to poll.
        rules: Control rules, defined after those of the domain.
    """

    def __init__(
        self,
        problem: Problem,
        options: SearchOptions | None = None,
        rules: RuleSet | None = None,
    ) -> None:
        raise NotImplementedError

    def step(self) -> Event | None:
        """Go on to the next event; None when the search has ended (``Finished`` was last).

        Raises:
            SequenceError: If an action is executing and its outcome was not given.
        """
        raise NotImplementedError

    def events(self) -> Iterator[Event]:
        """Yield the events to the end; the caller answers each before asking for the next."""
        raise NotImplementedError

    def executed(
        self,
        *,
        added: Iterable[Literal] | None = None,
        deleted: Iterable[Literal] | None = None,
    ) -> None:
        """Give the outcome of the action asked for by ``Execute``.

        Without arguments everything went as predicted. With ``added`` or ``deleted`` these are
        all the changes that the action made, instead of the predicted ones: a robot that ended
        up in r-5305 gives ``added=[(robot-in-room r-5305)], deleted=[(robot-in-room r-5301)]``,
        an action without any effect ``added=[], deleted=[]``.
        """
        raise NotImplementedError

    def add_goal(self, facts: Iterable[Literal], goal: Literal) -> None:
        """Add a goal, and facts that come with it.

        Raises:
            UnknownNameError: For an unknown predicate or object (see ``add_object``).
            LiteralError: For a wrong number of arguments.
        """
        raise NotImplementedError

    def remove_goal(self, goal: Literal, facts: Iterable[Literal] = ()) -> None:
        """Drop a goal and retract ``facts`` that came with it; UnknownNameError if not a goal."""
        raise NotImplementedError

    def assert_facts(self, *facts: Literal) -> None:
        """Take in that others made ``facts`` true."""
        raise NotImplementedError

    def retract_facts(self, *facts: Literal) -> None:
        """Take in that others made ``facts`` false."""
        raise NotImplementedError

    def add_object(self, name: str, kind: str) -> None:
        """Add an object of type ``kind``; takes effect at once. UnknownNameError for the type."""
        raise NotImplementedError

    def stop(self, reason: str = "stopped by the caller") -> None:
        """End the search at the next step with status ``stopped``."""
        raise NotImplementedError

    @property
    def state(self) -> State:
        """The world as the search believes it to be at the current node."""
        raise NotImplementedError

    @property
    def goals(self) -> tuple[Literal, ...]:
        """The goals of the problem now, in the order in which they came."""
        raise NotImplementedError

    @property
    def trace(self) -> tuple[str, ...]:
        """The lines printed so far."""
        raise NotImplementedError

    @property
    def result(self) -> SearchResult | None:
        """The outcome, once finished."""
        raise NotImplementedError

    def pending_goals(self) -> tuple[Literal, ...]:
        """Return PG: goals needed, false, and not yet worked on; newest operator's first."""
        raise NotImplementedError

    def applicable_operators(self) -> tuple[StepView, ...]:
        """Return Applicable-Ops: by top-level goal in order of arrival, then newest first."""
        raise NotImplementedError

    def executed_operators(self) -> tuple[StepView, ...]:
        """Return Executed-Ops in order; without execution, the operators applied on this path."""
        raise NotImplementedError

    def pending_operators(self) -> tuple[StepView, ...]:
        """Return the chosen operators that are still to be applied, oldest first."""
        raise NotImplementedError

    def nodes(self) -> tuple[NodeView, ...]:
        """Return all nodes made so far, by number."""
        raise NotImplementedError
