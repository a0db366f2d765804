"""Which of several ready operators is applied when no rule says so."""

from __future__ import annotations

from rogue.prodigy._effects import gross_changes, makes
from rogue.prodigy._grounding import World
from rogue.prodigy._nodes import Node


def choose_applied(ready: list[Node], world: World) -> tuple[Node, str]:
    """Return the operator to apply of ``ready`` (newest first), and the reason.

    The order is PRODIGY4.0's: an operator that is free to go (nobody deletes what it adds, it
    deletes nobody's precondition), of several the newest; else one whose precondition another
    would delete and that threatens nobody; else the one with the fewest conflicts, of several
    the oldest.
    """
    if len(ready) == 1:
        return ready[0], "only one"
    conflicts = _Conflicts(ready, world)
    free = [n for n in ready if not conflicts.clobbered[n] and not conflicts.threatens[n]]
    if free:
        return free[0], "free to go"
    threatened = [n for n in ready if conflicts.threatened[n] and not conflicts.threatens[n]]
    if threatened:
        return threatened[0], "threatened by others"
    fewest = min(reversed(ready), key=lambda n: conflicts.clobbered[n] + conflicts.threatens[n])
    return fewest, "fewest conflicts"


class _Conflicts:
    """How often each operator's adds are clobbered, it threatens, and it is threatened."""

    def __init__(self, ready: list[Node], world: World) -> None:
        self.clobbered = dict.fromkeys(ready, 0)
        self.threatens = dict.fromkeys(ready, 0)
        self.threatened = dict.fromkeys(ready, 0)
        for node in ready:
            for other in ready:
                if node is not other:
                    self._compare(node, other, world)

    def _compare(self, node: Node, other: Node, world: World) -> None:
        assert node.instance is not None
        assert other.instance is not None
        adds, _ = gross_changes(node.instance, world)
        threat = other.instance
        self.clobbered[node] += sum(makes(threat, fact.negated(), world) for fact in adds)
        needs = node.instance.preconditions
        harmed = sum(makes(threat, literal.negated(), world) for literal in needs)
        self.threatened[node] += harmed
        self.threatens[other] += harmed
