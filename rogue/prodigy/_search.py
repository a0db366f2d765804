"""The search, driven by its caller."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from rogue.prodigy._engine import Engine
from rogue.prodigy._errors import SequenceError, UnknownNameError
from rogue.prodigy._events import Decided, Event, NodeView, StepView
from rogue.prodigy._options import SearchOptions
from rogue.prodigy._problem import Problem, check_literal
from rogue.prodigy._result import SearchResult, Stop
from rogue.prodigy._rules import RuleSet
from rogue.prodigy._snapshot import TreeSnapshot, take_snapshot
from rogue.prodigy._solutions import SolutionFilter
from rogue.prodigy._state import State
from rogue.prodigy._terms import Literal
from rogue.prodigy._types import Objects

Handler = Callable[["Search", object], Stop | None]
"""Called with the search and the data of a signal; may return a ``Stop`` to end the search."""


class Search:
    """One search, driven by its caller one event at a time.

    ``step`` goes on to the next event. At an ``Execute`` event the caller performs the action and
    calls ``executed``. Goals, objects and facts may be changed at any time; a change takes
    effect at the next poll, or at once at a ``Poll`` event, and with
    ``PollPoint.BEFORE_EXPANSION`` also at once while an action is executing::

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
        known: Solutions of an earlier search of the same problem, of which this one goes on.
    """

    def __init__(
        self,
        problem: Problem,
        options: SearchOptions | None = None,
        rules: RuleSet | None = None,
        *,
        known: SolutionFilter | None = None,
    ) -> None:
        self.problem = problem
        self.options = options or SearchOptions()
        of_domain = problem.domain.rules or RuleSet()
        self._engine = Engine(problem, self.options, of_domain + (rules or RuleSet()), known)
        self._events = self._engine.run()

    def step(self) -> Event | None:
        """Go on to the next event; None when the search has ended (``Finished`` was last).

        Raises:
            SequenceError: If an action is executing and its outcome was not given.
            FunctionError: If a function of the domain raises.
        """
        if self._engine.awaiting is not None:
            step = self._engine.awaiting.step()
            raise SequenceError(f"{step} is executing: give its outcome with executed() first")
        began = self.options.clock()
        self._engine.resumed_at = began
        self._engine.is_stepping = True
        try:
            return next(self._events, None)
        finally:
            self._engine.is_stepping = False
            self._engine.seconds += self.options.clock() - began

    def events(self) -> Iterator[Event]:
        """Yield the events to the end; the caller answers each before asking for the next."""
        while (event := self.step()) is not None:
            yield event

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

        Raises:
            SequenceError: If no action is executing.
            UnknownNameError: For an unknown predicate or object.
            LiteralError: For a wrong number of arguments.
        """
        if self._engine.awaiting is None:
            raise SequenceError("no action is executing")
        as_predicted = added is None and deleted is None
        facts = self._checked(added or ()), self._checked(deleted or ())
        self._engine.report(None if as_predicted else facts)

    def add_goal(self, facts: Iterable[Literal], goal: Literal) -> None:
        """Add a goal, and facts that come with it.

        A goal that is true already is no work: retract it first (``retract_facts``) where it is
        left over from an earlier time.

        Raises:
            UnknownNameError: For an unknown predicate or object (see ``add_object``).
            LiteralError: For a wrong number of arguments.
        """
        facts = self._checked(facts)
        self._checked([goal])
        self._engine.change(added=facts, goals=(goal,))

    def remove_goal(self, goal: Literal, facts: Iterable[Literal] = ()) -> None:
        """Drop a goal and retract ``facts`` that came with it.

        Raises:
            UnknownNameError: If it is not a goal now.
        """
        if goal not in self._engine.goals_to_be():
            raise UnknownNameError("goal", str(goal), map(str, self._engine.goals_to_be()))
        self._engine.change(deleted=self._checked(facts), dropped=(goal,))

    def assert_facts(self, *facts: Literal) -> None:
        """Take in that others made ``facts`` true; errors as ``add_goal``."""
        self._engine.change(added=self._checked(facts))

    def retract_facts(self, *facts: Literal) -> None:
        """Take in that others made ``facts`` false; errors as ``add_goal``."""
        self._engine.change(deleted=self._checked(facts))

    def add_object(self, name: str, kind: str) -> None:
        """Add an object of type ``kind``; takes effect at once. UnknownNameError for the type."""
        tree = self._engine.tree
        tree.objects = tree.objects.with_object(name, kind)
        if not tree.inference.is_idle:
            self._engine.change()

    def define_handler(self, condition: str, handler: Handler) -> None:
        """Run ``handler(search, data)`` at the poll after each signal of ``condition``.

        Handlers of "always" run at every poll, once a cycle; "start-run" and "achieve" are
        signalled by the search itself. A handler may change goals, objects and facts, give
        signals, and return a ``Stop`` to end the search. The polls are those of
        ``SearchOptions.poll``; handlers run before the ``Poll`` event.
        """
        self._engine.handlers.define(condition, lambda data: handler(self, data))

    def signal(self, condition: str, data: object = None) -> None:
        """Let the handlers of ``condition`` run at the next poll, with ``data``.

        Raises:
            UnknownNameError: If no handler was ever defined for it.
            OverflowError: If ten thousand signals wait already.
        """
        self._engine.handlers.signal(condition, data)

    def stop(self, reason: str = "stopped by the caller", *, by: str = "the caller") -> None:
        """End the search at the next step with status ``stopped``.

        An action that is executing needs no outcome then.
        """
        self._engine.stopped = Stop(reason, by)
        self._engine.awaiting = None

    def _checked(self, literals: Iterable[Literal]) -> tuple[Literal, ...]:
        literals = tuple(literals)
        for literal in literals:
            check_literal(literal, self.problem.domain, self._engine.tree.objects)
        return literals

    @property
    def state(self) -> State:
        """The world as the search believes it to be; before an action's changes while it runs."""
        return self._engine.current().state

    @property
    def objects(self) -> Objects:
        """The objects of the problem and those added since."""
        return self._engine.tree.objects

    @property
    def goals(self) -> tuple[Literal, ...]:
        """The goals of the problem now, in the order in which they came."""
        return self._engine.goals()

    @property
    def trace(self) -> tuple[str, ...]:
        """The lines printed so far."""
        return tuple(self._engine.trace.lines)

    @property
    def decisions(self) -> tuple[Decided, ...]:
        """The decisions so far, with their alternatives and the rules that decided them.

        The newest 20,000 of them, or ``max_held`` if that is less.
        """
        return tuple(self._engine.decided)

    @property
    def result(self) -> SearchResult | None:
        """The outcome, once finished."""
        return self._engine.result

    def pending_goals(self) -> tuple[Literal, ...]:
        """Return PG: goals needed, false, and not yet worked on; newest operator's first."""
        return tuple(self._engine.current().view.pending())

    def applicable_operators(self) -> tuple[StepView, ...]:
        """Return Applicable-Ops: by top-level goal in order of arrival, then newest first."""
        tail = self._engine.current().view
        return tuple(node.step() for node in tail.by_top_level_goal(tail.ready()))

    def executed_operators(self) -> tuple[StepView, ...]:
        """Return Executed-Ops in order; without execution, the operators applied on this path.

        Of a search that executes for long, only the newest ``max_held``.
        """
        return self._engine.plan()

    def pending_operators(self) -> tuple[StepView, ...]:
        """Return the chosen operators that are still to be applied, oldest first."""
        tail = self._engine.current().tail
        return tuple(n.step() for _, n in sorted(tail.items()) if not n.is_finish())

    def nodes(self) -> tuple[NodeView, ...]:
        """Return the nodes held, by number: all made so far, unless old history was let go."""
        return tuple(node.view() for node in self._engine.tree.nodes.values())

    def snapshot(self) -> TreeSnapshot:
        """Return the search tree as it stands, for drawing; at any time, also while it runs."""
        tree = self._engine.tree
        return take_snapshot(tree.nodes.values(), tree.at, tree.barrier)
