"""Walks in the tree, from a node to one that stands in a relation to it.

Source: TCA's ``tcaFindParentReference`` and its kin.
"""

from __future__ import annotations

from collections.abc import Iterator

from tca_bus._tree_queries import Relation
from tca_bus.tasktree._events import Role
from tca_bus.tasktree._view import View

PASSED_OVER = frozenset({Role.GATE, Role.LISTENER})
"""Roles that walks among siblings do not see: the listeners of taps."""


def find_relative(tree: View, id: str, relation: Relation, name: str | None) -> str | None:
    """The id of the node that stands in a relation to another; None when there is none.

    Raises:
        KeyError: there is no such node.
    """
    node = tree.node(id)
    match relation:
        case Relation.PARENT:
            return node.task.parent
        case Relation.TOP_LEVEL:
            return node.root
        case Relation.ANCESTOR:
            named = (above for above in _above(tree, id) if tree.node(above).task.name == name)
            return next(named, None)
        case Relation.FAILED:
            return _origin(tree, id, Role.RECOVERY)
        case Relation.TAPPED:
            tapped = node.origin.of if node.role in {*PASSED_OVER, Role.CLEAN_UP} else None
            return tapped if tapped in tree else None
        case Relation.NEXT | Relation.PREVIOUS:
            return _beside(tree, id, 1 if relation is Relation.NEXT else -1)
        case _:
            return _below(tree, id, relation, name)


def _above(tree: View, id: str) -> Iterator[str]:
    parent = tree.node(id).task.parent
    while parent is not None:
        yield parent
        parent = tree.node(parent).task.parent


def _origin(tree: View, id: str, role: Role) -> str | None:
    """What the nearest node of a role, here or above, belongs to."""
    for each in [id, *_above(tree, id)]:
        if tree.node(each).role is role:
            return tree.node(each).origin.of
    return None


def _below(tree: View, id: str, relation: Relation, name: str | None) -> str | None:
    children = [child for child in tree.node(id).children if child in tree]
    if relation is Relation.CHILD:
        return next((child for child in children if tree.node(child).task.name == name), None)
    seen = [child for child in children if tree.node(child).role not in PASSED_OVER]
    if not seen:
        return None
    return seen[0] if relation is Relation.FIRST_CHILD else seen[-1]


def _beside(tree: View, id: str, step: int) -> str | None:
    parent = tree.node(id).task.parent
    siblings = tree.roots() if parent is None else list(tree.node(parent).children)
    seen = [each for each in siblings if each in tree and tree.node(each).role not in PASSED_OVER]
    place = seen.index(id) + step if id in seen else -1
    return seen[place] if 0 <= place < len(seen) else None
