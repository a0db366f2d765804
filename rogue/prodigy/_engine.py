"""The main loop: visit, execute, expand, poll, choose the next node."""

from __future__ import annotations

from collections.abc import Iterator

from rogue.prodigy._effects import changes
from rogue.prodigy._events import (
    Announced,
    Decided,
    Event,
    Execute,
    Executed,
    Failed,
    Finished,
    NodeKind,
    Poll,
    Rerooted,
    StepView,
)
from rogue.prodigy._expand import Expander, Failure
from rogue.prodigy._nodes import Node, Situation
from rogue.prodigy._options import PollPoint, SearchOptions
from rogue.prodigy._problem import Problem
from rogue.prodigy._proof import prove_unsolvable
from rogue.prodigy._result import SearchResult, Status
from rogue.prodigy._rules import RuleSet
from rogue.prodigy._tail import Tail
from rogue.prodigy._terms import Literal
from rogue.prodigy._trace import ACHIEVED, Trace
from rogue.prodigy._tree import Tree

_EARLIER = {NodeKind.GOAL: 3, NodeKind.OPERATOR: 2, NodeKind.BINDING: 1, NodeKind.APPLIED: 0}
"""Levels before the depth bound at which a node cannot be applied in time any more."""

Facts = tuple[Literal, ...]


class Engine:
    """Runs one search; ``Search`` is what callers see of it.

    Attributes:
        awaiting: The applied node whose action is executing.
        resumed_at: When the caller last asked for an event.
        seconds: Time spent before that.
        stopped: Why the caller wants an end, or None.
    """

    def __init__(self, problem: Problem, options: SearchOptions, rules: RuleSet) -> None:
        self.options = options
        self.tree = Tree(problem)
        self.trace = Trace(options.level)
        self.decided: list[Decided] = []
        self.done: list[Node] = []
        self.awaiting: Node | None = None
        self._predicted: tuple[Facts, Facts] = ((), ())
        self._hopeless: Facts = ()
        self.stopped: str | None = None
        self.result: SearchResult | None = None
        self.resumed_at = self.seconds = 0.0
        self._expander = Expander(self.tree, rules, options.mode)
        self._last: Node | None = None
        self._polling = False
        self._changed = False
        self._queue: list[tuple[Facts, Facts, Facts, Facts]] = []

    def run(self) -> Iterator[Event]:
        """Yield the events of the search; the caller acts between them."""
        yield from self._announce_root()
        while (ended := self._ended()) is None:
            if not self.tree.open:
                yield from self._reroot()
                continue
            yield from self._cycle(self.tree.open[-1])
            if self.stopped is None:
                yield from self._poll()
                yield from self._finish_if_achieved()
        status, reason = ended
        yield Finished(self._conclude(status, reason))

    def _announce_root(self) -> Iterator[Event]:
        goal = self.tree.open[-1].parent
        assert goal is not None
        yield Announced(goal.view(), self.trace.node(goal))

    def _ended(self) -> tuple[Status, str] | None:
        if self.stopped is not None:
            return Status.STOPPED, self.stopped
        if self._is_achieved():
            return Status.SOLVED, ACHIEVED
        limit = self._limit()
        if limit:
            return Status.LIMIT, limit
        if not self.tree.open and not self._changed:
            return self._exhausted()
        return None

    def _is_achieved(self) -> bool:
        """Say whether *finish* is applicable and nothing remains to be executed for it."""
        node = self.tree.open[-1] if self.tree.open else self.tree.barrier
        situation = self.current()
        return node.visited and bool(situation.tail) and self._satisfied(situation)

    def _satisfied(self, situation: Situation) -> bool:
        finish = situation.tail[0] if situation.tail else None
        return finish is not None and self.tree.holds_in(finish, situation)

    def _limit(self) -> str:
        most, seconds = self.options.max_nodes, self.options.time_limit
        if most is not None and len(self.tree.nodes) >= most:
            return f"gave up after {most} nodes"
        if seconds is not None and self._elapsed() >= seconds:
            return f"gave up after {seconds:g} s"
        return ""

    def _elapsed(self) -> float:
        return self.seconds + self.options.clock() - self.resumed_at

    def _cycle(self, node: Node) -> Iterator[Event]:
        if self._must_execute(node):
            if not self._is_wanted(node):
                yield from self._fail(Failure(node, "no longer needed"))
                return
            yield from self._visit(node)
            yield from self._execute(node)
            if self.tree.open[-1:] != [node] or self.stopped or self._is_achieved():
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
            outcome = Failure(node, f"hit depth bound ({bound})")
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
        node.failure = failure.reason
        self.tree.close(node)
        self.trace.failure(node, failure.reason)
        yield Failed(node.view(), failure.reason)
        if failure.structural:
            self._propagate(node)

    def _propagate(self, node: Node) -> None:
        """Close what cannot succeed because ``node`` failed whatever the order of steps.

        An operator all of whose bindings failed so is closed, then its goal, then the operator
        that needs the goal with everything below it, and so on upwards, as far as the state is
        the same: in the state before an application the goal may still be within reach.
        """
        applied = _newest_applied(node)
        node.structural = True
        while node.structural:
            if node.kind is NodeKind.GOAL and node.needed_by:
                node = self._give_up(node.needed_by[0], applied)
            above = node.parent
            if above is None or node is applied or above.kind is NodeKind.APPLIED:
                return
            node = above
            node.structural = not (node.instances or node.operators) and all(
                child.structural for child in node.children
            )
            if node.structural:
                self.tree.close(node)

    def _give_up(self, consumer: Node, applied: Node) -> Node:
        top = consumer if consumer.depth > applied.depth else applied
        for lower in [n for n in self.tree.open if n.depth >= top.depth]:
            self.tree.close(lower)
        top.structural = True
        top.failure = top.failure or "requires an unsolvable precondition"
        return top

    def _must_execute(self, node: Node) -> bool:
        is_applied = node.kind is NodeKind.APPLIED and node.parent is not None
        return self.options.execute and is_applied and not node.executed

    def _is_wanted(self, node: Node) -> bool:
        assert node.parent is not None
        assert node.binding is not None
        tail = Tail(node.parent.situation, self.tree.needs)
        return node.binding in tail.ready()

    def _execute(self, node: Node) -> Iterator[Event]:
        assert node.instance is not None
        before = self.tree.before(node)
        predicted = changes(node.instance, self.tree.world(before.state))
        self.awaiting, self._predicted = node, (predicted.added, predicted.deleted)
        needs = node.instance.preconditions
        yield Execute(node.view(), node.step(), needs, predicted.added, predicted.deleted)
        if self.stopped is not None:
            return
        achieved = node.goal is None or node.situation.state.holds(node.goal)
        line = self.trace.line_of(node) if achieved else self.trace.not_achieved(node)
        yield Executed(node.view(), achieved, line)
        if self.options.poll is PollPoint.BEFORE_EXPANSION:
            yield from self._poll()

    def report(self, outcome: tuple[Facts, Facts] | None) -> None:
        """Correct the state by the outcome of the executing action; it is committed now."""
        node = self.awaiting
        assert node is not None
        added, deleted = self._predicted if outcome is None else outcome
        node.situation = self.tree.outcome(node, self.tree.before(node), added, deleted)
        node.executed = True
        self.done.append(node)
        self.tree.commit(node)
        self._changed = True
        self.awaiting = None

    def _poll(self) -> Iterator[Event]:
        self._integrate()
        self._polling = True
        yield Poll(len(self.tree.nodes))
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
            self.tree.extra = [g for g in self.tree.extra if g not in (*goals, *dropped)]
            self.tree.extra.extend(goals)
            self.tree.removed.update(dropped)
            self.tree.change(added, deleted, executing=self.awaiting is not None)
            self._changed = True
        self._queue.clear()

    def goals(self) -> Facts:
        """Return the goals now."""
        finish = next((n for n in reversed(self.tree.nodes) if n.is_finish()), None)
        return self.tree.needs(finish) if finish else tuple(self.tree.extra)

    def goals_to_be(self) -> Facts:
        """Return the goals as they will be when what is queued is taken in."""
        goals = list(self.goals())
        for _, _, new, dropped in self._queue:
            goals = [g for g in (*goals, *new) if g not in dropped]
        return tuple(goals)

    def current(self) -> Situation:
        """Return where the search stands: before the changes of an action not yet executed."""
        node = self.tree.open[-1] if self.tree.open else self.tree.barrier
        return self.tree.before(node) if self._must_execute(node) else node.situation

    def _finish_if_achieved(self) -> Iterator[Event]:
        """Announce, and execute, the last operator in the cycle that chose it.

        As PRODIGY does it before the depth advances, the line has the depth of the node before.
        """
        node = self.tree.open[-1] if self.tree.open else None
        if node is None or node.visited:
            return
        must_execute = self._must_execute(node)
        if must_execute and self._satisfied(self.current()):
            yield from self._fail(Failure(node, "no longer needed"))
        elif self._satisfied(node.situation):
            is_last = node.kind is NodeKind.APPLIED
            yield from self._visit(node, depth=node.depth - 1 if is_last else None)
            if must_execute:
                yield from self._execute(node)
                if self.options.poll is PollPoint.END_OF_CYCLE and self.stopped is None:
                    yield from self._poll()

    def _reroot(self) -> Iterator[Event]:
        """Start anew from the state after the last execution, keeping the goals."""
        self._changed = False
        state = self.tree.barrier.situation.state
        root = self.tree.plant(state)
        yield Rerooted(root.view(), "no alternatives are left since the last execution")
        yield from self._announce_root()

    def _exhausted(self) -> tuple[Status, str]:
        state = self.tree.barrier.situation.state
        goals = self.tree.goal_sets(state)
        proof = prove_unsolvable(self.tree.world(state), goals, self.options.proof_states)
        self._hopeless = proof.hopeless
        if proof.is_proved:
            return Status.UNSOLVABLE, proof.reason
        return Status.LIMIT, f"gave up: no alternatives are left; {proof.reason}"

    def plan(self) -> tuple[StepView, ...]:
        """Return the executed operators, or those applied on the path if none are executed."""
        if self.options.execute:
            return tuple(node.step() for node in self.done)
        node: Node | None = self.tree.open[-1] if self.tree.open else self.tree.barrier
        steps: list[StepView] = []
        while node is not None:
            if node.kind is NodeKind.APPLIED and node.parent is not None:
                steps.append(node.step())
            node = node.parent
        return tuple(reversed(steps))

    def _conclude(self, status: Status, reason: str) -> SearchResult:
        is_partial = status is not Status.SOLVED and not self.options.execute
        plan = () if is_partial else self.plan()
        self.trace.end(reason, [f"\t{step}" for step in plan])
        self.result = SearchResult(
            status,
            plan,
            len(self.tree.nodes),
            self._elapsed(),
            tuple(self.trace.lines),
            reason,
            self._hopeless,
        )
        return self.result


def _newest_applied(node: Node) -> Node:
    while node.kind is not NodeKind.APPLIED and node.parent is not None:
        node = node.parent
    return node
