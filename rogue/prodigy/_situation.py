"""What is so at a node of the search: the world, and what the operators chosen so far still need.

Situations are immutable and share what they have in common, so backtracking needs no undoing. A
``Draft`` makes the next one from the last at a cost in proportion to what changes.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

from immutables import Map

from rogue.prodigy._inference import Inferred
from rogue.prodigy._state import State
from rogue.prodigy._tail import Tail
from rogue.prodigy._terms import Literal

if TYPE_CHECKING:
    from rogue.prodigy._nodes import Node

Needs = tuple[Literal, ...]
World = tuple[State, frozenset[Literal]]
"""A state, and what eager rules inferred in it, on which it depends what they infer next."""
Changeable = frozenset[tuple[str, bool]]
"""Predicates that something can make true (True) or false (False)."""


@dataclass(frozen=True, eq=False)
class Situation:
    """What is so at a node.

    Attributes:
        facts: The simulated world, and what was inferred in it.
        past: The worlds that the path was in since the last change that it did not make.
        expanded: Goals being worked on, with the goal node of each. A literal leaves it when its
            truth changes.
        tail: Binding nodes chosen and not yet applied, by number.
        own_needs: Needs of nodes of the tail that differ from the preconditions of the instance.
        needed: For each literal, the nodes of the tail that need it, newest first.
        lacking: How many needs of each node of the tail are false.
        free: The nodes of the tail that lack nothing.
        wanted: Literals that are needed, false, and not being worked on.
        serving: How many nodes of the tail serve each goal.
        live: Numbers of nodes of the tail that are known to matter still.
        finish: The node of *finish* in the tail.
    """

    facts: Inferred
    past: Map[World, None]
    expanded: Map[Literal, Node]
    tail: Map[int, Node]
    own_needs: Map[int, Needs]
    needed: Map[Literal, tuple[Node, ...]]
    lacking: Map[int, int]
    free: Map[int, Node]
    wanted: Map[Literal, None]
    serving: Map[Literal, int]
    live: Map[int, None]
    finish: Node | None = None

    @staticmethod
    def at(facts: Inferred) -> Situation:
        """Return the situation at a root: nothing was chosen yet."""
        past: Map[World, None] = Map([(_world(facts), None)])
        return Situation(facts, past, Map(), Map(), Map(), Map(), Map(), Map(), Map(), Map(), Map())

    @property
    def state(self) -> State:
        """All that is true."""
        return self.facts.state

    def without_past(self) -> Situation:
        """Return this situation as one that no path led to."""
        return replace(self, past=Map([(_world(self.facts), None)]))

    def repeats(self, earlier: Situation) -> bool:
        """Say whether the world was like this at ``earlier`` or on the way to it."""
        return _world(self.facts) in earlier.past

    def needs(self, node: Node) -> Needs:
        """Return what a binding node needs: its preconditions, or what was made of them."""
        own = self.own_needs.get(node.number)
        if own is not None:
            return own
        return node.instance.preconditions if node.instance is not None else ()

    def lacks(self, node: Node) -> Needs:
        """Return the needs of a binding node that are false."""
        holds = self.state.holds
        return tuple(p for p in self.needs(node) if not holds(p))

    def is_achieved(self) -> bool:
        """Say whether *finish* is chosen and lacks nothing."""
        return self.finish is not None and not self.lacking[self.finish.number]

    @cached_property
    def view(self) -> Tail:
        """What can be asked about the tail."""
        return Tail(self)


class Draft:
    """The next situation in the making."""

    def __init__(self, start: Situation, changeable: Changeable) -> None:
        self._changeable = changeable
        self._facts = start.facts
        self._state = start.state
        self._past = start.past
        self._finish = start.finish
        self._live = start.view.live
        start.view.release()
        self._left: list[Literal] = []
        self._is_cut = False
        self._expanded = start.expanded.mutate()
        self._tail = start.tail.mutate()
        self._own_needs = start.own_needs.mutate()
        self._needed = start.needed.mutate()
        self._lacking = start.lacking.mutate()
        self._free = start.free.mutate()
        self._wanted = start.wanted.mutate()
        self._serving = start.serving.mutate()

    def done(self) -> Situation:
        """Return the situation made.

        Whatever mattered before matters still, unless a goal served by a node that is left, or a
        node that lacked something, was given up.
        """
        keeps_live = not self._is_cut and not any(g in self._serving for g in self._left)
        return Situation(
            self._facts,
            self._past,
            self._expanded.finish(),
            self._tail.finish(),
            self._own_needs.finish(),
            self._needed.finish(),
            self._lacking.finish(),
            self._free.finish(),
            self._wanted.finish(),
            self._serving.finish(),
            self._live if keeps_live else Map(),
            self._finish,
        )

    def expand(self, node: Node) -> None:
        """Note that the goal of a goal node is being worked on."""
        if node.goal is not None and not self._state.holds(node.goal):
            self._expanded[node.goal] = node
            self._wanted.pop(node.goal, None)

    def choose(self, node: Node, needs: Needs | None = None) -> None:
        """Take a binding node into the tail, with ``needs`` if they are not as written.

        If nothing can bring about what it lacks, its goal has to be reached in another way.
        """
        self._tail[node.number] = node
        if needs is not None:
            self._own_needs[node.number] = needs
            self._finish = node if node.is_finish() else self._finish
        if node.goal is not None:
            self._serving[node.goal] = self._serving.get(node.goal, 0) + 1
        self._need(node, self._needs(node))

    def drop(self, node: Node) -> None:
        """Take a binding node out of the tail."""
        for literal in self._needs(node):
            others = tuple(n for n in self._needed[literal] if n is not node)
            if others:
                self._needed[literal] = others
            else:
                del self._needed[literal]
                self._wanted.pop(literal, None)
        if node.goal is not None:
            others_serving = self._serving.get(node.goal, 1) - 1
            if others_serving:
                self._serving[node.goal] = others_serving
            else:
                del self._serving[node.goal]
        self._is_cut = self._is_cut or self._lacking[node.number] > 0
        del self._tail[node.number]
        del self._lacking[node.number]
        self._free.pop(node.number, None)
        self._own_needs.pop(node.number, None)

    def require(self, node: Node, needs: Needs) -> None:
        """Give a binding node of the tail other needs."""
        self.drop(node)
        self.choose(node, needs)

    def leave(self, goal: Literal) -> None:
        """Note that a goal is no longer being worked on."""
        if self._expanded.pop(goal, None) is not None:
            self._left.append(goal)
            self._want(goal)

    def move(self, facts: Inferred, changed: Iterable[Literal], *, forget: bool = False) -> None:
        """Go on to ``facts``, which differ from the last at most in ``changed``.

        What changes is no longer a goal being worked on. With ``forget`` earlier states may come
        again: the world changed by itself.
        """
        before, state = self._state, facts.state
        self._facts, self._state = facts, state
        world = _world(facts)
        self._past = Map({world: None}) if forget else self._past.set(world, None)
        for fact in changed:
            if before.holds(fact) != state.holds(fact):
                self._flip(fact if state.holds(fact) else fact.negated())

    def _flip(self, now_true: Literal) -> None:
        now_false = now_true.negated()
        for literal in (now_true, now_false):
            if self._expanded.pop(literal, None) is not None:
                self._left.append(literal)
            self._wanted.pop(literal, None)
        for node in self._needed.get(now_true, ()):
            self._count(node, self._lacking[node.number] - 1)
        for node in self._needed.get(now_false, ()):
            self._count(node, self._lacking[node.number] + 1)
        self._want(now_false)
        if self._is_hopeless(now_false):
            for node in self._needed.get(now_false, ()):
                self._give_up(node)

    def _needs(self, node: Node) -> Needs:
        own = self._own_needs.get(node.number)
        if own is not None:
            return own
        assert node.instance is not None
        return node.instance.preconditions

    def _need(self, node: Node, needs: Needs) -> None:
        lacking = 0
        for literal in needs:
            self._needed[literal] = _newest_first(node, self._needed.get(literal, ()))
            if not self._state.holds(literal):
                lacking += 1
                self._want(literal)
                if self._is_hopeless(literal):
                    self._give_up(node)
        self._count(node, lacking)

    def _count(self, node: Node, lacking: int) -> None:
        self._lacking[node.number] = lacking
        if lacking:
            self._free.pop(node.number, None)
        else:
            self._free[node.number] = node

    def _want(self, literal: Literal) -> None:
        is_open = literal not in self._expanded and not self._state.holds(literal)
        if is_open and literal in self._needed:
            self._wanted[literal] = None

    def _is_hopeless(self, literal: Literal) -> bool:
        return (literal.predicate, literal.positive) not in self._changeable

    def _give_up(self, node: Node) -> None:
        goal = node.goal
        if goal is not None and self._expanded.get(goal) is node.goal_node:
            self.leave(goal)


def _world(facts: Inferred) -> World:
    return facts.base, facts.eager


def _newest_first(node: Node, others: tuple[Node, ...]) -> tuple[Node, ...]:
    if not others or others[0].number < node.number:
        return (node, *others)
    return tuple(sorted((node, *others), key=lambda n: -n.number))
