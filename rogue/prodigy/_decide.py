"""Making a choice: control rules first, then PRODIGY's defaults; and noting why."""

from __future__ import annotations

from dataclasses import dataclass

from rogue.prodigy._control import Filtered, filter_candidates, prefer_candidate
from rogue.prodigy._events import Choice, Decided, NodeView, RuleFired
from rogue.prodigy._nodes import Node
from rogue.prodigy._result import Limit
from rogue.prodigy._rules import Action, Candidate, DecideRule, RuleSet
from rogue.prodigy._running_view import RunningView
from rogue.prodigy._tree import Tree


@dataclass(frozen=True, slots=True)
class Failure:
    """Why a node failed.

    Attributes:
        node: The node.
        reason: PRODIGY's words for it.
        structural: No other order of steps would change it.
        limit: The bound at which it was given up, if it was.
    """

    node: Node
    reason: str
    structural: bool = False
    limit: Limit | None = None


@dataclass(frozen=True, slots=True)
class Picked:
    """What was chosen, among what, and why."""

    chosen: Candidate
    left: tuple[Candidate, ...]
    fired: tuple[RuleFired, ...]
    reason: str


class Decider:
    """Asks the control rules of a search.

    Attributes:
        decisions: What was decided and why, since they were last taken away.
    """

    def __init__(self, tree: Tree, rules: RuleSet) -> None:
        self._tree = tree
        self.rules = rules
        self.decisions: list[Decided] = []

    def view(self, node: Node) -> RunningView:
        """Return the search as rules see it at ``node``."""
        return RunningView(node, self._tree.objects)

    def filter(self, choice: Choice, node: Node, candidates: tuple[Candidate, ...]) -> Filtered:
        """Return what select and reject rules leave of ``candidates``."""
        return filter_candidates(self.rules, choice, self.view(node), candidates)

    def prefer(
        self, choice: Choice, node: Node, filtered: Filtered
    ) -> tuple[Candidate | None, tuple[RuleFired, ...]]:
        """Return what prefer rules make of it, None if they say nothing, and what fired."""
        return prefer_candidate(self.rules, choice, self.view(node), filtered.candidates)

    def pick(self, choice: Choice, node: Node, filtered: Filtered) -> Picked:
        """Choose one of the candidates left: as prefer rules say, else the first."""
        candidates, fired = filtered.candidates, filtered.fired
        chosen, links = self.prefer(choice, node, filtered)
        if chosen is not None:
            return Picked(chosen, candidates, fired + links, links[-1].rule)
        default = "only one" if len(candidates) == 1 else "first"
        return Picked(candidates[0], candidates, fired, fired[-1].rule if fired else default)

    def has_rules(self, choice: Choice) -> bool:
        """Say whether any select, reject or prefer rule is about ``choice``."""
        return any(
            rule.choice is choice for rule in self.rules.rules if not isinstance(rule, DecideRule)
        )

    def note_decided(self, node: Node, action: Action, rule: str) -> None:
        """Note that a rule decided between sub-goaling and applying at ``node``."""
        ways = (Action.SUB_GOAL.value, Action.APPLY.value, Action.PROTECT.value)
        fired = (RuleFired(rule, action.value, ()),)
        self.decisions.append(
            Decided(Choice.DECIDE, node.number, None, action.value, ways, rule, fired)
        )

    def note_protection(self, node: Node, child: Node, ways: tuple[str, ...]) -> None:
        """Note that ``child`` was made for the first of ``ways`` to protect something."""
        child.decided_by = "only one" if len(ways) == 1 else "first"
        view = child.view()
        self.decisions.append(
            Decided(Choice.PROTECT, node.number, view, ways[0], ways, child.decided_by)
        )

    def note_refused(self, choice: Choice, node: Node, filtered: Filtered) -> None:
        """Note that rules left nothing to choose from."""
        gone = tuple(text for fired in filtered.fired for text in fired.effect)
        reason = filtered.fired[-1].rule
        self.decisions.append(Decided(choice, node.number, None, "", gone, reason, filtered.fired))

    def note_node(self, newest: Node, node: Node, picked: Picked) -> None:
        """Note that rules chose the node to go on with."""
        text = f"n{node.number}"
        others = tuple(f"n{c.number}" for c in picked.left if isinstance(c, NodeView))
        self.decisions.append(
            Decided(
                Choice.NODE, newest.number, node.view(), text, others, picked.reason, picked.fired
            )
        )

    def note(self, choice: Choice, node: Node, child: Node, picked: Picked) -> None:
        """Note that ``child`` was made for what was chosen at ``node``."""
        removed = [e for f in picked.fired if f.action == "reject" for e in f.effect]
        child.decided_by = picked.reason
        self.decisions.append(
            Decided(
                choice,
                node.number,
                child.view(),
                str(picked.chosen),
                (*map(str, picked.left), *removed),
                picked.reason,
                picked.fired,
            )
        )
