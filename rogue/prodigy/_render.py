"""Goal trees as text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rogue.prodigy._goal_tree import GoalTree, Standing, TreeNode


def render_tree(tree: GoalTree) -> str:
    """Return a goal tree as indented text, a goal or an operator a line, then the plan.

    Goals stand in round brackets under the operator that needs them, operators in angle brackets
    under the goal that they serve, each with how it stands. A goal that several operators need
    stands under the first; the others refer to it.
    """
    lines = [f"{row.indent}{row.branch}{_text(row)}" for row in _rows(tree)]
    if tree.left_out:
        lines.append(f"{tree.left_out} more goals and operators are not shown.")
    if tree.steps:
        lines += ["", "Solution:" if tree.status == "solved" else "Plan:"]
        lines += [f"{at:3d} {s.text} {s.standing.value}" for at, s in enumerate(tree.steps, 1)]
    return "\n".join(lines)


class _Row(NamedTuple):
    """A node as it is printed; a reference stands for one that is printed elsewhere."""

    node: TreeNode
    indent: str
    branch: str
    is_reference: bool


def _rows(tree: GoalTree) -> Iterator[_Row]:
    known = {node.number: node for node in tree.nodes}
    below: dict[int, list[tuple[TreeNode, bool]]] = {number: [] for number in known}
    roots = [node for node in tree.nodes if node.above not in known]
    for node in tree.nodes:
        for number in (node.above, *node.shared_by):
            if number in known:
                below[number].append((node, number != node.above))
    agenda = [_Row(node, "", "", is_reference=False) for node in reversed(roots)]
    while agenda:
        row = agenda.pop()
        yield row
        if not row.is_reference:
            agenda.extend(reversed(_below(row, below[row.node.number])))


def _below(row: _Row, nodes: list[tuple[TreeNode, bool]]) -> list[_Row]:
    indent = row.indent + {"": "", "├─ ": "│  ", "└─ ": "   "}[row.branch]
    branches = ["├─ "] * (len(nodes) - 1) + ["└─ "]
    return [
        _Row(node, indent, branch, is_reference)
        for (node, is_reference), branch in zip(nodes, branches, strict=False)
    ]


def _text(row: _Row) -> str:
    node = row.node
    opening, closing = "()" if node.is_goal else "<>"
    words = " ".join(filter(None, (node.name, node.args)))
    text = f"{opening}{words}{closing}"
    if row.is_reference:
        return f"{text}, see n{node.number}"
    return f"n{node.number} {text} {_standing(node)}"


def _standing(node: TreeNode) -> str:
    said = node.standing.value
    if node.applied and node.standing in {Standing.DONE, Standing.EXECUTED, Standing.RUNNING}:
        said = f"{said} as n{node.applied[-1]}"
    return f"{said}: {node.note}" if node.note else said
