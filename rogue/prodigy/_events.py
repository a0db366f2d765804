"""What a search tells its caller, one frozen value per event."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from rogue.prodigy._result import SearchResult
from rogue.prodigy._terms import Literal, Value


class NodeKind(StrEnum):
    """What a node of the search tree decides."""

    GOAL = "goal"
    OPERATOR = "operator"
    BINDING = "binding"
    PROTECTION = "protection"
    APPLIED = "applied-op"


class Choice(StrEnum):
    """What a decision, and a control rule, is about."""

    GOAL = "goal"
    OPERATOR = "operator"
    PROTECT = "protect"
    BINDINGS = "bindings"
    APPLIED_OP = "applied-op"
    DECIDE = "apply-or-subgoal"
    NODE = "node"


@dataclass(frozen=True, slots=True)
class NodeView:
    """A node as it was when it was looked at.

    Attributes:
        number: The n in ``n18``.
        kind: What it decides.
        text: What is printed behind the number, ``<GOTO-PICKUP-LOC MITCHELL R-5303>``.
        depth: Depth in the search tree; the root n1 has 1.
        level: Depth in the goal tree, the indentation.
        parent: Number of the parent, 0 for the root.
        literal: The goal of a goal node, and the goal served by the others.
        operator: Name of the operator, empty for goal nodes.
        args: Values of the operator's ``params``, empty before they are bound.
        failure: Why it failed, empty if it did not.
        executed: Whether its action was executed.
        above: Numbers of what it hangs from in the goal tree: of a goal the bindings that needed
            it when it was chosen, of an operator or binding its goal, of an applied operator its
            binding.
        needs: Preconditions of a binding or applied operator.
    """

    number: int
    kind: NodeKind
    text: str
    depth: int
    level: int
    parent: int
    literal: Literal | None
    operator: str
    args: tuple[Value, ...]
    failure: str = ""
    executed: bool = False

    def __str__(self) -> str:
        return f"n{self.number}"

    above: tuple[int, ...] = ()
    needs: tuple[Literal, ...] = ()


@dataclass(frozen=True, slots=True)
class StepView:
    """An instantiated operator, as in a plan: name, values of ``params``, all bindings.

    ``number`` is the node that decided it: the binding node of an operator not yet applied, the
    applied node of one that was.
    """

    number: int
    operator: str
    args: tuple[Value, ...]
    bindings: tuple[tuple[str, Value], ...] = ()

    def __str__(self) -> str:
        return "<" + " ".join([self.operator, *map(str, self.args)]).upper() + ">"


@dataclass(frozen=True, slots=True)
class RuleFired:
    """A control rule that took part in a decision: what it kept, removed or preferred."""

    rule: str
    action: str
    effect: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Decided:
    """A choice was made.

    Attributes:
        choice: What was chosen among.
        at: Number of the node whose expansion it was.
        node: The node made for what was chosen; None if every candidate was refused, and for
            the choice between sub-goaling and applying.
        chosen: Text of what was chosen.
        alternatives: Texts of the candidates before any rule, in their order.
        reason: Name of the rule that decided, or of the default (``first``, ``free to go``, ...).
        rules: All rules that took part, in their order.
    """

    choice: Choice
    at: int
    node: NodeView | None
    chosen: str
    alternatives: tuple[str, ...]
    reason: str
    rules: tuple[RuleFired, ...] = ()


@dataclass(frozen=True, slots=True)
class Announced:
    """A node was visited; ``line`` is its trace line, empty where PRODIGY prints none."""

    node: NodeView
    line: str


@dataclass(frozen=True, slots=True)
class Failed:
    """A node failed; ``reason`` is PRODIGY's words for it, ``line`` its trace line with them."""

    node: NodeView
    reason: str
    line: str = ""


@dataclass(frozen=True, slots=True)
class Execute:
    """The caller shall perform ``step`` in the world, then call ``Search.executed``.

    ``added`` and ``deleted`` are the changes that the operator predicts.
    """

    node: NodeView
    step: StepView
    preconditions: tuple[Literal, ...]
    added: tuple[Literal, ...]
    deleted: tuple[Literal, ...]


@dataclass(frozen=True, slots=True)
class Executed:
    """The outcome was taken in; ``line`` is the node's trace line with its warning, if any."""

    node: NodeView
    achieved: bool
    line: str


@dataclass(frozen=True, slots=True)
class Poll:
    """The caller may add and remove goals, objects and facts now. ``nodes``: made so far."""

    nodes: int


@dataclass(frozen=True, slots=True)
class Found:
    """A search for several solutions found one, its ``number`` from 1; it goes on."""

    plan: tuple[StepView, ...]
    number: int


@dataclass(frozen=True, slots=True)
class Rerooted:
    """What was left after the last execution is exhausted: the search starts anew from there."""

    root: NodeView
    reason: str


@dataclass(frozen=True, slots=True)
class Finished:
    """The last event."""

    result: SearchResult


Event = Decided | Announced | Failed | Execute | Executed | Poll | Found | Rerooted | Finished
