"""Protection: operators whose conditional effects would undo what others need.

Off unless asked for. Where nothing else is left to try, the condition of the harmful effect is made
false first: what that takes becomes a further need of the operator.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rogue.prodigy._domain import Effect
from rogue.prodigy._expressions import TRUE
from rogue.prodigy._grounding import World
from rogue.prodigy._nodes import Node
from rogue.prodigy._situation import Needs, Situation
from rogue.prodigy._terms import Literal


@dataclass(frozen=True, slots=True)
class Protection:
    """A way to keep an operator from doing harm.

    Attributes:
        binding: The node that binds it.
        saved: What its conditional effect would make false.
        needs: What has to hold besides its preconditions for the effect not to happen.
    """

    binding: Node
    saved: Literal
    needs: Needs

    def __str__(self) -> str:
        return f"protect {self.saved} from {self.binding.instance}"


def protections(situation: Situation, world: World) -> Iterator[Protection]:
    """Yield the ways to protect what is needed from operators that are ready, newest first."""
    for node in situation.view.ready():
        assert node.instance is not None
        for effect in node.instance.operator.effects:
            if effect.condition != TRUE:
                yield from _from(effect, node, situation, world)


def _from(effect: Effect, node: Node, situation: Situation, world: World) -> Iterator[Protection]:
    assert node.instance is not None
    known = situation.needs(node)
    for case in world.combinations(effect.variables, node.instance.bindings):
        harmed = effect.atom.ground(case, positive=not effect.adds)
        others = [n for n in situation.needed.get(harmed, ()) if n is not node]
        if not others or not world.state.holds(harmed):
            continue
        if world.holds(effect.condition, case):
            for branch in world.branches(effect.condition, case, positive=False):
                if not any(literal.negated() in known for literal in branch):
                    more = tuple(literal for literal in branch if literal not in known)
                    yield Protection(node, harmed, more)
