"""The ways in which a search ends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from rogue.prodigy._grounding import World
from rogue.prodigy._options import Solutions
from rogue.prodigy._proof import proof_budget, prove_unsolvable
from rogue.prodigy._result import Limit, LimitKind, SearchResult, Status, Stop
from rogue.prodigy._terms import Literal
from rogue.prodigy._trace import ACHIEVED

if TYPE_CHECKING:
    from rogue.prodigy._engine import Engine


@dataclass(frozen=True, slots=True)
class Ending:
    """How a search ends: its status and why."""

    status: Status
    reason: str
    limit: Limit | None = None
    stop: Stop | None = None
    hopeless: tuple[Literal, ...] = ()

    @staticmethod
    def by(stop: Stop) -> Ending:
        """Return the end of a search that was stopped."""
        return Ending(Status.STOPPED, stop.why, stop=stop)

    @staticmethod
    def at(limit: Limit, more: str = "") -> Ending:
        """Return the end of a search that gave up."""
        return Ending(Status.LIMIT, f"{limit}; {more}" if more else str(limit), limit)


def achieved() -> Ending:
    """Return the end of a search that looked for one solution and has it."""
    return Ending(Status.SOLVED, ACHIEVED)


def limit_reached(engine: Engine) -> Ending | None:
    """Return the end of a search that has reached one of its bounds, else None."""
    options, tree = engine.options, engine.tree
    if options.max_nodes is not None and tree.made >= options.max_nodes:
        return Ending.at(Limit(LimitKind.NODES, options.max_nodes))
    if options.time_limit is not None and engine.elapsed() >= options.time_limit:
        return Ending.at(Limit(LimitKind.SECONDS, options.time_limit))
    if max(len(tree.nodes), engine.solutions.held) >= options.max_held:
        return Ending.at(Limit(LimitKind.HELD, options.max_held))
    return None


def exhausted(engine: Engine) -> Ending:
    """Return the end of a search that has nothing left to try."""
    options, tree = engine.options, engine.tree
    cut = engine.cut
    if engine.solutions.count:
        count = engine.solutions.count
        found = "1 solution was found" if count == 1 else f"{count} solutions were found"
        reason = f"{found}; {cut}" if cut else f"{found}; no alternatives are left"
        return Ending(Status.SOLVED, reason, cut)
    facts = tree.barrier.situation.facts
    goals = tree.goal_sets(facts.state)
    budget = proof_budget(options.proof_states, engine.is_late)
    world = World(tree.domain, tree.objects, facts.base, budget)
    proof = prove_unsolvable(world, goals, options.proof_states, tree.inference, facts)
    if proof.is_proved:
        return Ending(Status.UNSOLVABLE, proof.reason, hopeless=proof.hopeless)
    limit = cut or Limit(LimitKind.PROOF_STATES, options.proof_states)
    return Ending.at(limit, proof.reason)


def conclude(engine: Engine, ending: Ending) -> SearchResult:
    """Print the end of a search and return its outcome."""
    several = engine.options.solutions is not Solutions.ONE
    count = engine.solutions.count if several else int(ending.status is Status.SOLVED)
    status = ending.status
    if count and status is Status.LIMIT:
        status = Status.SOLVED
    is_partial = status is not Status.SOLVED and not engine.options.execute
    plan = engine.solutions.last if several else () if is_partial else engine.plan()
    engine.trace.end(ending.reason, [] if several else [f"\t{step}" for step in plan])
    return SearchResult(
        status,
        plan,
        engine.tree.made,
        engine.elapsed(),
        tuple(engine.trace.lines),
        ending.reason,
        ending.hopeless,
        ending.limit,
        ending.stop,
        count,
    )
