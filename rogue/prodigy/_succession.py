"""What is so after each node of the search, given what was so before it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from rogue.prodigy._effects import changes, says
from rogue.prodigy._events import NodeKind
from rogue.prodigy._inference import Inference
from rogue.prodigy._instances import DONE
from rogue.prodigy._nodes import Node
from rogue.prodigy._situation import Draft, Situation
from rogue.prodigy._state import State
from rogue.prodigy._terms import Literal

if TYPE_CHECKING:
    from rogue.prodigy._tree import Tree


class Succession:
    """Makes situations for the nodes of a tree."""

    def __init__(self, tree: Tree) -> None:
        self._tree = tree

    @property
    def _inference(self) -> Inference:
        return self._tree.inference

    def _draft(self, start: Situation) -> Draft:
        return Draft(start, self._tree.domain.changed)

    def after(self, node: Node, above: Situation) -> Situation:
        """Return what is so after ``node`` if ``above`` is so before it."""
        match node.kind:
            case NodeKind.GOAL:
                draft = self._draft(above)
                draft.expand(node)
                return draft.done()
            case NodeKind.BINDING:
                draft = self._draft(above)
                draft.choose(node, self._tree.finish_needs(node) if node.is_finish() else None)
                return self._chained(draft.done())
            case NodeKind.PROTECTION if node.protection is not None:
                draft = self._draft(above)
                binding = node.protection.binding
                draft.require(binding, (*above.needs(binding), *node.protection.needs))
                return draft.done()
            case NodeKind.APPLIED:
                return self._applied(node, above)
        return above

    def _applied(self, node: Node, above: Situation) -> Situation:
        assert node.instance is not None
        node.before = None
        made = changes(node.instance, self._tree.world(above.state), above.facts.base)
        return self.outcome(node, above, made.added, made.deleted)

    def before(self, applied: Node) -> Situation:
        """Return the situation before an applied node's changes, its operator taken out."""
        if applied.before is None:
            assert applied.parent is not None
            applied.before = self._without(applied, applied.parent.situation).done()
        return applied.before

    def _without(self, applied: Node, above: Situation) -> Draft:
        draft = self._draft(above)
        if applied.binding is not None and applied.binding.number in above.tail:
            draft.drop(applied.binding)
        return draft

    def outcome(
        self,
        applied: Node,
        above: Situation,
        added: Iterable[Literal],
        deleted: Iterable[Literal],
        *,
        unforeseen: bool = False,
    ) -> Situation:
        """Return the situation after an operator was applied with the given changes.

        Args:
            applied: Its node.
            above: What was so before.
            added: What became true.
            deleted: What became false.
            unforeseen: It is not what the operator predicts: earlier states may come again.
        """
        added, deleted = tuple(added), tuple(deleted)
        draft = self._without(applied, above)
        if applied.goal is not None:
            draft.leave(applied.goal)
        base = above.facts.base.changed(added, deleted)
        self._move(draft, above, base, (*added, *deleted), forget=unforeseen)
        return self._chained(draft.done())

    def _move(
        self,
        draft: Draft,
        above: Situation,
        base: State,
        changed: Iterable[Literal],
        *,
        forget: bool,
    ) -> None:
        """Go on to the facts ``base``, with what inference rules make of them."""
        facts = self._inference.after(above.facts, self._tree.world(base))
        if not self._inference.is_idle:
            changed = facts.state.difference(above.state)
        draft.move(facts, changed, forget=forget)

    def _chained(self, situation: Situation) -> Situation:
        """Return the situation once every lazy rule chosen that can fire has fired."""
        while self._inference.lazy_rules:
            nodes = situation.free.values()
            ready = [n for n in nodes if n.operator in self._inference.lazy_rules]
            if not ready:
                break
            situation = self._fired(min(ready, key=lambda n: n.number), situation)
        return situation

    def _fired(self, node: Node, above: Situation) -> Situation:
        """Return the situation after a lazy rule was fired."""
        assert node.instance is not None
        assert node.goal is not None
        world = self._tree.world(above.state)
        said = frozenset({node.goal, *says(node.instance, world)})
        facts = self._inference.fired(above.facts, said, world)
        draft = self._draft(above)
        draft.drop(node)
        draft.leave(node.goal)
        draft.move(facts, list(facts.state.difference(above.state)))
        return draft.done()

    def changed(
        self, situation: Situation, added: tuple[Literal, ...], deleted: tuple[Literal, ...]
    ) -> Situation:
        """Return ``situation`` with facts, and the goals of the problem, as they are now."""
        draft = self._draft(situation)
        if situation.finish is not None:
            draft.require(situation.finish, self._tree.finish_needs(situation.finish))
        base = situation.facts.base.changed(added, deleted)
        base = self._inference.rooted(self._tree.world(base))
        self._move(draft, situation, base, (*added, *deleted), forget=True)
        return self._chained(draft.done())

    def change(
        self,
        added: tuple[Literal, ...],
        deleted: tuple[Literal, ...],
        *,
        executing: bool = False,
    ) -> None:
        """Take in a change of the world: it is so from the barrier on, whatever is tried.

        Choices on the path are open again; an applied operator that is no longer ready, or a
        goal that is no longer wanted, is given up with what follows it; not so while the last
        operator of the path is executing.
        """
        tree = self._tree
        path = tree.path()
        tree.barrier.situation = self.changed(tree.barrier.situation, added, deleted)
        kept = [tree.barrier]
        for node in path[1:]:
            above = kept[-1].situation
            if not executing and not _still_makes_sense(node, above):
                break
            node.situation = self.after(node, above)
            kept.append(node)
        tree.reopen(kept)


def _still_makes_sense(node: Node, above: Situation) -> bool:
    if node.binding is not None:
        return not above.lacks(node.binding)
    if node.protection is not None:
        return node.protection.binding.number in above.tail
    if node.kind is NodeKind.GOAL and node.goal is not None and node.goal != DONE:
        return node.goal in above.wanted and bool(above.view.consumers(node.goal))
    return True
