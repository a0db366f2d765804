"""Who waits for whom, and whether that closes a ring.

A member waits until each of its clauses is met; a clause is met when so many of the members in it
have moved. Those that can never move are what is left when all that may move have been taken out.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

Member = tuple[Literal["hold", "task"], str]
"""A hold or a task of the tree, by its id."""


@dataclass(frozen=True, slots=True)
class Clause:
    """At least ``needs`` of these have to move."""

    needs: int
    of: frozenset[Member]


Clauses = Callable[[Member], Sequence[Clause]]
"""What a member waits for; nothing when it moves by itself."""


def find_ring(start: Member, clauses: Clauses) -> list[Member] | None:
    """A ring of members that wait for each other and that ``start`` waits for.

    None when what ``start`` waits for may still move.
    """
    waits = _reachable(start, clauses)
    stuck = _stuck(waits)
    if start not in stuck:
        return None
    path: dict[Member, None] = {}
    member = start
    while member not in path:
        path[member] = None
        member = _next(member, waits, stuck)
    members = list(path)
    return members[members.index(member) :]


def _reachable(start: Member, clauses: Clauses) -> dict[Member, Sequence[Clause]]:
    waits: dict[Member, Sequence[Clause]] = {}
    todo = [start]
    while todo:
        member = todo.pop()
        if member not in waits:
            waits[member] = clauses(member)
            todo += [other for clause in waits[member] for other in clause.of]
    return waits


def _stuck(waits: Mapping[Member, Sequence[Clause]]) -> set[Member]:
    behind: dict[Member, list[Member]] = defaultdict(list)
    for member, clauses in waits.items():
        for clause in clauses:
            for other in clause.of:
                behind[other].append(member)
    stuck = {member for member, clauses in waits.items() if clauses}
    moved = deque(member for member in waits if member not in stuck)
    while moved:
        for member in behind[moved.popleft()]:
            if member in stuck and all(_is_met(clause, stuck) for clause in waits[member]):
                stuck.remove(member)
                moved.append(member)
    return stuck


def _is_met(clause: Clause, stuck: set[Member]) -> bool:
    return len(clause.of - stuck) >= clause.needs


def _next(member: Member, waits: Mapping[Member, Sequence[Clause]], stuck: set[Member]) -> Member:
    unmet = next(clause for clause in waits[member] if not _is_met(clause, stuck))
    return min(unmet.of & stuck)
