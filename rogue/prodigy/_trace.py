"""The printed lines of a search, as PRODIGY4.0 prints them."""

from __future__ import annotations

from rogue.prodigy._events import Choice, Decided, NodeKind, RuleFired
from rogue.prodigy._nodes import Node

ACHIEVED = "Achieved top-level goals."
NOT_ACHIEVED = " warning: desired goal was not achieved"


_PLURALS = {Choice.GOAL: "goals", Choice.OPERATOR: "operators", Choice.NODE: "nodes"}


class Trace:
    """Lines of the levels 0 (nothing), 1 (the plan), 2 (nodes) and 3 (nodes and rules).

    Attributes:
        lines: The newest lines.
        dropped: How many older ones were let go.
    """

    def __init__(self, level: int, most: int) -> None:
        self._level = level
        self._most = most
        self._at: dict[int, int] = {}
        self.lines: list[str] = []
        self.dropped = 0

    def node(self, node: Node, *, depth: int | None = None) -> str:
        """Print the line of a node that is visited; return it, "" where none is printed."""
        is_shown = node.kind is not NodeKind.OPERATOR and node.parent is not None
        return self._print(node, node.depth if depth is None else depth) if is_shown else ""

    def again(self, node: Node) -> str:
        """Print the line of a node to which the search comes back from elsewhere."""
        return "" if node.kind is NodeKind.GOAL else self._print(node, node.depth)

    def failure(self, node: Node, reason: str) -> str:
        """Print why a node failed, behind its line."""
        if node.number not in self._at:
            self._print(node, node.depth)
        return self._amend(node, f" ...{reason}")

    def not_achieved(self, node: Node) -> str:
        """Print behind an executed node's line that its goal is still false."""
        return self._amend(node, NOT_ACHIEVED)

    def rule(self, decided: Decided, fired: RuleFired) -> None:
        """Print a rule that fired."""
        if self._level < 3:
            return
        if decided.choice is Choice.DECIDE:
            self._append(f"    Firing {fired.action} rule {fired.rule}")
            return
        what = _PLURALS.get(decided.choice, decided.choice.value)
        listed = " ".join(fired.effect)
        self._append(f"    Firing {fired.action} {what} rule {fired.rule} to get ({listed})")

    def line_of(self, node: Node) -> str:
        """Return the newest line of a node, "" if it has none."""
        at = self._at.get(node.number)
        return "" if at is None else self.lines[at - self.dropped]

    def end(self, text: str, plan: list[str]) -> None:
        """Print the outcome, at level 1 with the plan."""
        if self._level >= 1:
            self._append(text)
        if self._level == 1:
            for step in plan:
                self._append(step)

    def solution(self, plan: list[str]) -> None:
        """Print that one of several solutions was found."""
        self.end(ACHIEVED, plan)

    def _append(self, line: str) -> None:
        self.lines.append(line)
        if len(self.lines) > 2 * self._most:
            del self.lines[: self._most]
            self.dropped += self._most
            self._at = {n: at for n, at in self._at.items() if at >= self.dropped}

    def _print(self, node: Node, depth: int) -> str:
        others = f" [{node.alternatives}]" if node.alternatives else ""
        line = f"{depth:3d} {'  ' * node.level}n{node.number} {node.text()}{others}"
        if self._level >= 2:
            self._at[node.number] = self.dropped + len(self.lines)
            self._append(line)
        return line if self._level >= 2 else ""

    def _amend(self, node: Node, text: str) -> str:
        at = self._at.get(node.number)
        if at is None:
            return ""
        self.lines[at - self.dropped] += text
        return self.lines[at - self.dropped]
