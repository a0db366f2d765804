"""The main loop: choose a node, visit, execute, expand, poll."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Iterator

from rogue.prodigy._budget import Budget, OutOfTimeError
from rogue.prodigy._conclusion import Ending, achieved, conclude, exhausted, limit_reached
from rogue.prodigy._effects import changes
from rogue.prodigy._errors import TooManyValuesError
from rogue.prodigy._events import (
    Announced,
    Decided,
    Event,
    Execute,
    Executed,
    Failed,
    Finished,
    Found,
    NodeKind,
    Poll,
    Rerooted,
    StepView,
)
from rogue.prodigy._excision import excise
from rogue.prodigy._expand import Expander, Failure
from rogue.prodigy._handlers import ACHIEVE, START_RUN, Handlers
from rogue.prodigy._nodes import Node
from rogue.prodigy._options import PollPoint, SearchOptions, Solutions
from rogue.prodigy._problem import Problem
from rogue.prodigy._result import Limit, LimitKind, SearchResult, Stop
from rogue.prodigy._rules import RuleSet
from rogue.prodigy._situation import Situation
from rogue.prodigy._solutions import SolutionFilter
from rogue.prodigy._terms import Literal
from rogue.prodigy._trace import Trace
from rogue.prodigy._tree import Tree

_EARLIER = {
    NodeKind.GOAL: 3,
    NodeKind.OPERATOR: 2,
    NodeKind.BINDING: 1,
    NodeKind.PROTECTION: 1,
    NodeKind.APPLIED: 0,
}
"""Levels before the depth bound at which a node cannot be applied in time any more."""

MOST_DECISIONS = 20_000
"""Decisions held at most; each lists all its alternatives."""

Facts = tuple[Literal, ...]


class Engine:
    """Runs one search; ``Search`` is what callers see of it.

    Attributes:
        awaiting: The applied node whose action is executing.
        cut: The first bound at which a branch was cut.
        is_stepping: The search is running, not the caller.
        resumed_at: When the caller last asked for an event.
        seconds: Time spent before that.
        stopped: Who wants an end and why, or None.
    """

    def __init__(
        self,
        problem: Problem,
        options: SearchOptions,
        rules: RuleSet,
        known: SolutionFilter | None = None,
    ) -> None:
        self.options = options
        self.is_stepping = False
        self.resumed_at = self.seconds = 0.0
        self.tree = Tree(problem, Budget(options.max_bindings, self.is_late))
        self.trace = Trace(options.level, options.max_held)
        self.handlers = Handlers()
        self.solutions = known or SolutionFilter(options)
        self.decided: deque[Decided] = deque(maxlen=min(options.max_held, MOST_DECISIONS))
        self.done: deque[StepView] = deque(maxlen=options.max_held)
        self.awaiting: Node | None = None
        self.cut: Limit | None = None
        self.stopped: Stop | None = None
        self.result: SearchResult | None = None
        self._predicted: tuple[Facts, Facts] = ((), ())
        self._expander = Expander(self.tree, rules, options)
        self._last: Node | None = None
        self._polling = False
        self._changed = False
        self._queue: list[tuple[Facts, Facts, Facts, Facts]] = []

    def run(self) -> Iterator[Event]:
        """Yield the events of the search; the caller acts between them."""
        try:
            ending = yield from self._search()
        except TooManyValuesError as error:
            ending = Ending.at(Limit(LimitKind.BINDINGS, error.most))
        except OutOfTimeError:
            ending = Ending.at(Limit(LimitKind.SECONDS, self.options.time_limit or 0.0))
        self.result = conclude(self, ending)
        yield Finished(self.result)

    def _search(self) -> Generator[Event, None, Ending]:
        self.handlers.signal(START_RUN)
        yield from self._announce_root()
        while (ending := self._ended()) is None:
            self.tree.budget.renew()
            if self._is_achieved():
                yield from self._take_solution()
            elif not self.tree.open:
                yield from self._reroot()
            else:
                yield from self._one_cycle()
        return ending

    def _one_cycle(self) -> Iterator[Event]:
        node = self._expander.choose_node()
        yield from self._decisions()
        if node is None or self._expander.is_spent(node):
            for spent in [node] if node is not None else list(self.tree.open.values()):
                self.tree.close(spent)
            return
        yield from self._cycle(node)
        if self.stopped is None:
            yield from self._poll()
            yield from self._finish_if_achieved()

    def _announce_root(self) -> Iterator[Event]:
        goal = self.tree.at.parent
        assert goal is not None
        yield Announced(goal.view(), self.trace.node(goal))

    def _ended(self) -> Ending | None:
        if self._is_achieved() and self.stopped is None:
            self.stopped = self._signal_achieved()
        if self.stopped is not None:
            return Ending.by(self.stopped)
        if self._is_achieved():
            return achieved() if self.options.solutions is Solutions.ONE else None
        limit = limit_reached(self)
        if limit is not None:
            return limit
        if not self.tree.open and not self._changed:
            return exhausted(self)
        return None

    def _signal_achieved(self) -> Stop | None:
        """Let the handlers of "achieve" run; they may change goals."""
        if not self.handlers.has(ACHIEVE):
            return None
        self.handlers.signal(ACHIEVE)
        self._polling = True
        stop = self.handlers.poll()
        self._polling = False
        return stop

    def _take_solution(self) -> Iterator[Event]:
        """Report a solution, and look for another from where the search is."""
        plan = self.plan()
        self.tree.close(self.tree.at)
        if self.solutions.accepts(plan):
            self.trace.solution([f"\t{step}" for step in plan])
            yield Found(plan, self.solutions.count)

    def _is_achieved(self) -> bool:
        """Say whether *finish* is applicable and nothing remains to be executed for it."""
        return self.tree.at.visited and self.current().is_achieved()

    def is_late(self) -> bool:
        """Say whether the time is up in the midst of a step."""
        limit = self.options.time_limit
        return self.is_stepping and limit is not None and self.elapsed() >= limit

    def elapsed(self) -> float:
        """Return the seconds spent searching."""
        return self.seconds + self.options.clock() - self.resumed_at

    def _cycle(self, node: Node) -> Iterator[Event]:
        if self.must_execute(node):
            if not self._is_wanted(node):
                yield from self._fail(Failure(node, "no longer needed"))
                return
            yield from self._visit(node)
            yield from self._execute(node)
            if self.tree.at is not node or self.stopped or self._is_achieved():
                return
        else:
            yield from self._visit(node)
        yield from self._expand(node)

    def _visit(self, node: Node, *, depth: int | None = None) -> Iterator[Event]:
        if not node.visited:
            node.visited = True
            yield Announced(node.view(), self.trace.node(node, depth=depth))
        elif self._last is not None and self._last.parent is not node and self._last is not node:
            yield Announced(node.view(), self.trace.again(node))
        self._last = node

    def _expand(self, node: Node) -> Iterator[Event]:
        bound = self.options.depth_bound
        outcome: Node | Failure | None
        if bound is not None and node.depth + _EARLIER[node.kind] > bound:
            limit = Limit(LimitKind.DEPTH, bound)
            outcome = Failure(node, f"hit depth bound ({bound})", limit=limit)
        elif self.solutions.is_too_long(node):
            outcome = Failure(node, "no better than a plan that was found")
        else:
            outcome = self._expander.expand(node)
        yield from self._decisions()
        if outcome is None:
            self.tree.close(node)
        elif isinstance(outcome, Failure):
            yield from self._fail(outcome)

    def _decisions(self) -> Iterator[Event]:
        for decided in self._expander.decisions:
            self.decided.append(decided)
            for fired in decided.rules:
                self.trace.rule(decided, fired)
            yield decided
        self._expander.decisions.clear()

    def _fail(self, failure: Failure) -> Iterator[Event]:
        node = failure.node
        self.cut = self.cut or failure.limit
        node.failure = failure.reason
        self.tree.close(node)
        line = self.trace.failure(node, failure.reason)
        yield Failed(node.view(), failure.reason, line)
        if failure.structural and self.options.excise_loops:
            excise(node, self.tree)

    def must_execute(self, node: Node) -> bool:
        """Say whether the action of an applied node is still to be executed."""
        return self.options.execute and node.is_step() and not node.executed

    def _is_wanted(self, node: Node) -> bool:
        assert node.parent is not None
        assert node.binding is not None
        above = node.parent.situation
        return node.binding.number in above.free and above.view.is_live(node.binding)

    def _execute(self, node: Node) -> Iterator[Event]:
        assert node.instance is not None
        before = self.tree.next_situation.before(node)
        predicted = changes(node.instance, self.tree.world(before.state), before.facts.base)
        self.awaiting, self._predicted = node, (predicted.added, predicted.deleted)
        needs = node.instance.preconditions
        yield Execute(node.view(), node.step(), needs, predicted.added, predicted.deleted)
        if self.stopped is not None:
            return
        reached = node.goal is None or node.situation.state.holds(node.goal)
        line = self.trace.line_of(node) if reached else self.trace.not_achieved(node)
        yield Executed(node.view(), reached, line)
        if self.options.poll is PollPoint.BEFORE_EXPANSION:
            yield from self._poll()

    def report(self, outcome: tuple[Facts, Facts] | None) -> None:
        """Correct the state by the outcome of the executing action; it is committed now."""
        node = self.awaiting
        assert node is not None
        self.tree.budget.renew()
        added, deleted = self._predicted if outcome is None else outcome
        succession = self.tree.next_situation
        unforeseen = (set(added), set(deleted)) != tuple(map(set, self._predicted))
        above = succession.before(node)
        node.situation = succession.outcome(node, above, added, deleted, unforeseen=unforeseen)
        if self.options.revisit:
            node.situation = node.situation.without_past()
        node.executed = True
        self.done.append(node.step())
        self.tree.commit(node)
        self.tree.forget(self.options.max_held // 2)
        self._changed = True
        self.awaiting = None

    def _poll(self) -> Iterator[Event]:
        self._integrate()
        self._polling = True
        self.stopped = self.handlers.poll() or self.stopped
        yield Poll(self.tree.made)
        self._polling = False

    def change(
        self,
        *,
        added: Facts = (),
        deleted: Facts = (),
        goals: Facts = (),
        dropped: Facts = (),
    ) -> None:
        """Queue a change of the world or the goals; take it in at once where that is allowed."""
        self._queue.append((added, deleted, goals, dropped))
        early = self.options.poll is PollPoint.BEFORE_EXPANSION
        if self._polling or (early and self.awaiting is not None):
            self._integrate()

    def _integrate(self) -> None:
        for added, deleted, goals, dropped in self._queue:
            self.tree.budget.renew()
            self.tree.change_goals(goals, dropped)
            self.tree.next_situation.change(added, deleted, executing=self.awaiting is not None)
            self._changed = True
        self._queue.clear()

    def goals(self) -> Facts:
        """Return the goals now."""
        situation = self.tree.at.situation
        if situation.finish is None:
            return tuple(self.tree.extra)
        return situation.needs(situation.finish)

    def goals_to_be(self) -> Facts:
        """Return the goals as they will be when what is queued is taken in."""
        goals = list(self.goals())
        for _, _, new, dropped in self._queue:
            goals = [g for g in (*goals, *new) if g not in dropped]
        return tuple(goals)

    def current(self) -> Situation:
        """Return where the search stands: before the changes of an action not yet executed."""
        node = self.tree.at
        return self.tree.next_situation.before(node) if self.must_execute(node) else node.situation

    def _finish_if_achieved(self) -> Iterator[Event]:
        """Announce, and execute, the last operator in the cycle that chose it.

        As PRODIGY does it before the depth advances, the line has the depth of the node before.
        """
        node = self.tree.at
        if node.visited:
            return
        must_execute = self.must_execute(node)
        if must_execute and self.current().is_achieved():
            yield from self._fail(Failure(node, "no longer needed"))
        elif node.situation.is_achieved():
            is_last = node.kind is NodeKind.APPLIED
            yield from self._visit(node, depth=node.depth - 1 if is_last else None)
            if must_execute:
                yield from self._execute(node)
                if self.options.poll is PollPoint.END_OF_CYCLE and self.stopped is None:
                    yield from self._poll()

    def _reroot(self) -> Iterator[Event]:
        """Start anew from the state after the last execution, keeping the goals."""
        self._changed = False
        root = self.tree.plant(self.tree.barrier.situation.facts.base)
        yield Rerooted(root.view(), "no alternatives are left since the last execution")
        yield from self._announce_root()

    def plan(self) -> tuple[StepView, ...]:
        """Return the executed operators, or those applied on the path if none are executed."""
        if self.options.execute:
            return tuple(self.done)
        node: Node | None = self.tree.at
        steps: list[StepView] = []
        while node is not None:
            if node.is_step():
                steps.append(node.step())
            node = node.parent
        return tuple(reversed(steps))
