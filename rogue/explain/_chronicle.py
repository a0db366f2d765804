"""From the decisions of a search to what they mean for each request."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeVar

from rogue.explain._decision import Decision, DecisionKind, Rival
from rogue.prodigy import Choice, Decided, Failed, Literal, NodeKind, NodeView, Value

MOST_NODES = 20_000
"""Nodes of a search that are remembered; of a longer one the newest."""

_KINDS = {
    Choice.GOAL: DecisionKind.GOAL,
    Choice.OPERATOR: DecisionKind.OPERATOR,
    Choice.BINDINGS: DecisionKind.BINDINGS,
    Choice.APPLIED_OP: DecisionKind.STEP,
}

_Ids = frozenset[str]
_Key = TypeVar("_Key")
_Told = TypeVar("_Told")


@dataclass(frozen=True, slots=True)
class Concern:
    """A request that takes part in a search: its errand, how important it is, and since when."""

    id: str
    user: str
    item: str
    rank: int
    posted: float


class Chronicle:
    """Follows one search: which requests each node serves, and so whom a decision concerns.

    A goal of the problem belongs to the request whose user and item are its first arguments;
    whatever is chosen below it serves that request. An operator that needs a goal which is being
    worked on already makes the two requests share it.
    """

    def __init__(self) -> None:
        self._concerns: dict[str, Concern] = {}
        self._owners: dict[tuple[Value, ...], str] = {}
        self._serves: dict[int, _Ids] = {}
        self._texts: dict[str, _Ids] = {}
        self._bindings: dict[int, list[NodeView]] = {}
        self._worked_on: dict[Literal, int] = {}
        self._waits: dict[str, str] = {}
        self._overtaken: dict[str, _Ids] = {}
        self._planned: set[str] = set()
        self._selecting = ""

    def admit(self, concern: Concern) -> None:
        """Let a request take part; the newest one of a user and item owns their goal."""
        self._concerns[concern.id] = concern
        self._owners[concern.user, concern.item] = concern.id

    def withdraw(self, request_id: str) -> None:
        """Let a request take part no more."""
        self._waits.pop(request_id, None)
        self._overtaken.pop(request_id, None)
        self._planned.discard(request_id)
        gone = self._concerns.pop(request_id, None)
        if gone is not None and self._owners.get((gone.user, gone.item)) == request_id:
            del self._owners[gone.user, gone.item]

    def note(self, event: Decided | Failed, now: float) -> list[Decision]:
        """Return what an event of the search means for requests; ``now`` is its time."""
        if isinstance(event, Failed):
            return self._dead_end(event, now)
        if event.node is None or event.choice not in _KINDS:
            return []
        ids = self._learn(event.node)
        decisions = [self._chosen(event, ids, now)]
        if event.choice is Choice.APPLIED_OP:
            decisions += self._waiting(event, ids, now)
        if event.choice is Choice.BINDINGS:
            decisions += self._merged(event.node, ids, now)
        return [decision for decision in decisions if decision.requests]

    def _dead_end(self, event: Failed, now: float) -> list[Decision]:
        ids = self._serves.get(event.node.number) or self._learn(event.node)
        if not self._known(ids):
            return []
        return [
            Decision(
                time=now,
                kind=DecisionKind.DEAD_END,
                requests=self._known(ids),
                chosen=event.node.text,
                reason=event.reason,
            )
        ]

    def _learn(self, node: NodeView) -> _Ids:
        """Note whom a new node serves."""
        ids: _Ids = frozenset().union(*(self._serves.get(n, frozenset()) for n in node.above))
        if node.kind is NodeKind.GOAL and not ids and node.literal is not None:
            owner = self._owners.get(node.literal.args[:2])
            ids = frozenset({owner}) if owner else ids
        self._serves[node.number] = ids
        if node.kind is NodeKind.GOAL and node.literal is not None:
            self._worked_on[node.literal] = node.number
        elif node.kind is NodeKind.BINDING:
            self._bindings.setdefault(node.above[0], []).append(node)
            self._texts[node.text] = ids
        elif node.kind is NodeKind.APPLIED and node.literal is not None:
            self._worked_on.pop(node.literal, None)
        self._forget()
        return ids

    def _forget(self) -> None:
        _trim(self._serves)
        _trim(self._texts)
        _trim(self._bindings)

    def _chosen(self, event: Decided, ids: _Ids, now: float) -> Decision:
        kind = _KINDS[event.choice]
        if kind is DecisionKind.GOAL and self._is_own_goal(event):
            kind = DecisionKind.PLANNED
            self._planned |= ids
            self._selecting = next((f.rule for f in event.rules if f.action == "select"), "")
        others = self._owners_of(_others(event)) if kind is DecisionKind.PLANNED else frozenset()
        return Decision(
            time=now,
            kind=kind,
            requests=self._known(ids),
            rule=event.reason,
            chosen=event.chosen,
            over=_others(event),
            rivals=self._rivals(others - ids),
        )

    def _is_own_goal(self, event: Decided) -> bool:
        assert event.node is not None
        literal = event.node.literal
        return literal is not None and literal.args[:2] in self._owners and event.node.level <= 1

    def _waiting(self, event: Decided, ids: _Ids, now: float) -> list[Decision]:
        """What a step means for those for whom another could have been taken, or none yet."""
        for request_id in ids:
            self._waits.pop(request_id, None)
        rules = {one: self._selecting for one in self._concerns if one not in self._planned}
        removed = {text: fired.rule for fired in event.rules for text in fired.effect}
        for text in _others(event):
            for request_id in self._texts.get(text, ()):
                rules[request_id] = removed.get(text, event.reason)
        return [
            Decision(
                time=now,
                kind=kind,
                requests=(request_id,),
                rule=rules[request_id],
                chosen=event.chosen,
                over=_others(event),
                rivals=self._rivals(ids),
            )
            for request_id in self._known(rules)
            if request_id not in ids
            and (kind := self._news(request_id, ids, rules[request_id])) is not None
        ]

    def _news(self, request_id: str, ids: _Ids, rule: str) -> DecisionKind | None:
        """How a request was passed over; that it waits on by the same rule is no news."""
        kind = self._how_passed(request_id, ids)
        is_news = kind is DecisionKind.OVERTAKEN or self._waits.get(request_id) != rule
        self._waits[request_id] = rule
        return kind if is_news else None

    def _how_passed(self, request_id: str, ids: _Ids) -> DecisionKind:
        own = self._concerns[request_id]
        before = self._overtaken.get(request_id, frozenset())
        rivals = [self._concerns[one] for one in self._known(ids - before)]
        order = list(self._concerns)
        late = {
            rival.id
            for rival in rivals
            if rival.rank > own.rank
            and rival.posted >= own.posted
            and order.index(rival.id) > order.index(own.id)
        }
        self._overtaken[request_id] = before | late
        return DecisionKind.OVERTAKEN if late else DecisionKind.WAITS

    def _merged(self, node: NodeView, ids: _Ids, now: float) -> list[Decision]:
        """Goals that the chosen operator needs, and that are being worked on for others."""
        found = []
        for need in node.needs:
            goal = self._worked_on.get(need)
            others = self._serves.get(goal, frozenset()) - ids if goal is not None else frozenset()
            if goal is None or not self._known(others):
                continue
            self._serves[goal] = others | ids
            for binding in self._bindings.get(goal, ()):
                self._serves[binding.number] = self._texts[binding.text] = others | ids
            for own, shared_with in ((ids, others), (others, ids)):
                found.append(
                    Decision(
                        time=now,
                        kind=DecisionKind.MERGED,
                        requests=self._known(own),
                        chosen=str(need),
                        rivals=self._rivals(shared_with),
                    )
                )
        return found

    def _known(self, ids: Iterable[str]) -> tuple[str, ...]:
        return tuple(sorted(one for one in ids if one in self._concerns))

    def _rivals(self, ids: _Ids) -> tuple[Rival, ...]:
        return tuple(Rival(one, self._concerns[one].rank) for one in self._known(ids))

    def _owners_of(self, goals: Iterable[str]) -> _Ids:
        words = (goal.strip("()").split()[1:3] for goal in goals)
        owners = (self._owners.get(tuple(pair)) for pair in words)
        return frozenset(owner for owner in owners if owner)


def _trim(known: dict[_Key, _Told]) -> None:
    while len(known) > MOST_NODES:
        del known[next(iter(known))]


def _others(event: Decided) -> tuple[str, ...]:
    return tuple(text for text in event.alternatives if text != event.chosen)
