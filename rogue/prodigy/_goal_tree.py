"""The goal tree of a search: what is wanted, which operator was chosen for it, how each stands.

It is what Figures 5 and 9 of Haigh & Veloso (1996) draw: goals and operators, without the nodes
that only record a decision. An applied operator is told at the operator that was applied.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import islice
from typing import TYPE_CHECKING

from rogue.prodigy._events import Decided, NodeKind, NodeView
from rogue.prodigy._instances import FINISH

if TYPE_CHECKING:
    from rogue.prodigy._search import Search


class Standing(StrEnum):
    """How a goal or an operator of the tree stands."""

    PENDING = "pending"
    """The goal is false and wanted; the operator was chosen and not applied yet."""
    RUNNING = "executing"
    """The operator was sent to be executed, and its outcome is not known yet."""
    DONE = "done"
    """The goal was reached; the operator was applied in the planner's mind."""
    EXECUTED = "executed"
    """The operator was executed in the world."""
    FAILED = "failed"
    """It cannot be had in this way; the note says why."""
    DROPPED = "given up"
    """The search went another way, or nobody wants it any more."""


_OPEN = frozenset({Standing.PENDING, Standing.RUNNING})
_GONE = frozenset({Standing.FAILED, Standing.DROPPED})

MOST_OTHERS = 12
"""Alternatives that are told of one choice."""


@dataclass(frozen=True, slots=True)
class TreeNode:
    """A goal or an operator of the goal tree.

    Attributes:
        number: The n of its node.
        is_goal: A goal, or else an operator.
        name: Predicate or operator; ``not`` stands before that of a negative goal.
        args: Arguments, separated by blanks.
        standing: How it stands.
        above: Number of the operator that it was chosen for, or of the goal that the operator
            serves; 0 for a goal of the problem.
        shared_by: Numbers of the other operators that need the goal.
        applied: Numbers of the nodes that applied the operator, in their order.
        note: Why it failed, empty if it did not.
        reason: Name of the rule that chose it, or of the default.
        over: What else could have been chosen, at most `MOST_OTHERS`.
    """

    number: int
    is_goal: bool
    name: str
    args: str
    standing: Standing
    above: int = 0
    shared_by: tuple[int, ...] = ()
    applied: tuple[int, ...] = ()
    note: str = ""
    reason: str = ""
    over: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class TreeStep:
    """A step of the plan.

    Attributes:
        number: Node that applied it, one of ``TreeNode.applied``.
        text: ``<goto-pickup-loc mitchell r-5303>``.
        standing: Done or executed.
    """

    number: int
    text: str
    standing: Standing


@dataclass(frozen=True, slots=True)
class GoalTree:
    """The goal tree with the plan beneath it.

    Attributes:
        nodes: By number.
        steps: What was applied or executed, in order.
        status: How the search ended, empty while it runs.
        left_out: How many nodes are not there, since they failed or are old.
    """

    nodes: tuple[TreeNode, ...] = ()
    steps: tuple[TreeStep, ...] = ()
    status: str = ""
    left_out: int = 0

    def pruned(self, *, most_live: int, most_gone: int) -> GoalTree:
        """Return the tree with at most so many nodes.

        Args:
            most_live: Of those that count, the newest are kept.
            most_gone: Of the failed and given up ones, those that were tried first.
        """
        live = [node.number for node in self.nodes if node.standing not in _GONE]
        kept, left = set(live[max(len(live) - most_live, 0) :]), most_gone
        for node in self.nodes:
            is_placed = not node.above or node.above in kept
            if node.standing in _GONE and left and is_placed:
                kept.add(node.number)
                left -= 1
        nodes = tuple(node for node in self.nodes if node.number in kept)
        gone = self.left_out + len(self.nodes) - len(nodes)
        return replace(self, nodes=nodes, left_out=gone)


def goal_tree(search: Search) -> GoalTree:
    """Return the goal tree of ``search`` as it stands; it may be looked at while it runs."""
    drawn = _Drawing(search)
    executing = search.options.execute
    standing = Standing.EXECUTED if executing else Standing.DONE
    steps = (TreeStep(s.number, str(s).lower(), standing) for s in search.executed_operators())
    status = search.result.status.value if search.result else ""
    return GoalTree(drawn.nodes(), tuple(steps), status)


_ROOTS = 2
"""Depth down to which a search decides nothing: the root, and the goal (done)."""


class _Drawing:
    """What is drawn of one search."""

    def __init__(self, search: Search) -> None:
        self._search = search
        views = search.nodes()
        self._views = {view.number: view for view in views}
        self._applied = _applied_by_binding(views)
        self._on_path = {step.number for step in search.executed_operators()}
        self._pending = {step.number for step in search.pending_operators()}
        self._wanted = frozenset(search.pending_goals())
        self._running = _running(views) if search.options.execute else 0
        self._decided = {d.node.number: d for d in search.decisions if d.node is not None}
        self._bindings: dict[int, list[NodeView]] = {}
        for view in views:
            if view.kind is NodeKind.BINDING and view.above:
                self._bindings.setdefault(view.above[0], []).append(view)

    def nodes(self) -> tuple[TreeNode, ...]:
        shown = [view for view in self._views.values() if _is_shown(view)]
        standings = {view.number: self._standing(view) for view in shown}
        sharers = self._sharers(shown, standings)
        return tuple(self._node(view, standings[view.number], sharers) for view in shown)

    def _node(self, view: NodeView, standing: Standing, sharers: dict[int, list[int]]) -> TreeNode:
        name, args = _words(view)
        decided = self._why(view)
        known = [n if self._is_drawn(n) else 0 for n in view.above] or [0]
        shared = dict.fromkeys([*known[1:], *sharers.get(view.number, ())])
        return TreeNode(
            number=view.number,
            is_goal=view.kind is NodeKind.GOAL,
            name=name,
            args=args,
            standing=standing,
            above=known[0],
            shared_by=tuple(n for n in shared if n and n != known[0]),
            applied=tuple(one.number for one in self._applied.get(view.number, ())),
            note=view.failure,
            reason=decided.reason if decided else "",
            over=_others(decided) if decided else (),
        )

    def _why(self, view: NodeView) -> Decided | None:
        """The choice of the bindings, or of the operator where there was but one binding."""
        decided = self._decided.get(view.number)
        if decided is None or _others(decided) or view.kind is not NodeKind.BINDING:
            return decided
        return self._decided.get(view.parent, decided)

    def _standing(self, view: NodeView) -> Standing:
        if view.kind is NodeKind.GOAL:
            return self._standing_of_goal(view)
        if view.kind is NodeKind.OPERATOR:
            return Standing.FAILED
        return self._standing_of_binding(view)

    def _standing_of_binding(self, view: NodeView) -> Standing:
        applied = self._applied.get(view.number, ())
        if any(one.executed for one in applied):
            return Standing.EXECUTED
        if any(one.number in self._on_path for one in applied):
            return Standing.DONE
        if any(one.number == self._running for one in applied):
            return Standing.RUNNING
        if view.number in self._pending and self._search.result is None:
            return Standing.PENDING
        return Standing.FAILED if view.failure else Standing.DROPPED

    def _standing_of_goal(self, view: NodeView) -> Standing:
        assert view.literal is not None
        below = {self._standing_of_binding(one) for one in self._bindings.get(view.number, ())}
        if {Standing.DONE, Standing.EXECUTED} & below:
            return Standing.DONE
        if view.failure:
            return Standing.FAILED
        if not any(map(self._is_live, view.above)):
            return Standing.DROPPED
        if self._search.state.holds(view.literal):
            return Standing.DONE
        is_wanted = view.literal in self._wanted or _OPEN & below
        return Standing.PENDING if is_wanted else Standing.DROPPED

    def _is_drawn(self, number: int) -> bool:
        return number in self._views and _is_shown(self._views[number])

    def _is_live(self, number: int) -> bool:
        """Say whether an operator counts still; of one that was let go nothing else is known."""
        view = self._views.get(number)
        return view is None or _is_finish(view) or self._standing_of_binding(view) not in _GONE

    def _sharers(
        self, shown: Iterable[NodeView], standings: dict[int, Standing]
    ) -> dict[int, list[int]]:
        """Operators that came later and need a goal that was being worked on already."""
        live = [view for view in shown if standings[view.number] not in _GONE]
        goals = {view.literal: view.number for view in live if view.kind is NodeKind.GOAL}
        sharers: dict[int, list[int]] = {}
        for view in live:
            for need in view.needs:
                if goals.get(need, view.number) < view.number:
                    sharers.setdefault(goals[need], []).append(view.number)
        return sharers


def _is_finish(view: NodeView) -> bool:
    return view.operator == FINISH


def _is_shown(view: NodeView) -> bool:
    if _is_finish(view) or view.depth <= _ROOTS:
        return False
    if view.kind is NodeKind.OPERATOR:
        return bool(view.failure)
    return view.kind in {NodeKind.GOAL, NodeKind.BINDING}


def _running(views: Iterable[NodeView]) -> int:
    """The applied node whose outcome is not known yet, 0 if there is none."""
    applied = [view for view in views if view.kind is NodeKind.APPLIED and view.above]
    is_running = applied and not applied[-1].executed and not applied[-1].failure
    return applied[-1].number if is_running else 0


def _applied_by_binding(views: Iterable[NodeView]) -> dict[int, list[NodeView]]:
    applied: dict[int, list[NodeView]] = {}
    for view in views:
        if view.kind is NodeKind.APPLIED and view.above:
            applied.setdefault(view.above[0], []).append(view)
    return applied


def _words(view: NodeView) -> tuple[str, str]:
    if view.kind is not NodeKind.GOAL or view.literal is None:
        return view.operator, " ".join(map(str, view.args))
    sign = "" if view.literal.positive else "not "
    return f"{sign}{view.literal.predicate}", " ".join(map(str, view.literal.args))


def _others(decided: Decided) -> tuple[str, ...]:
    others = (text for text in decided.alternatives if text != decided.chosen)
    return tuple(islice(others, MOST_OTHERS))
