"""Planning without a caller in the loop."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rogue.prodigy._errors import SequenceError
from rogue.prodigy._grounding import World
from rogue.prodigy._instances import all_instances, finish_operator
from rogue.prodigy._options import SearchOptions
from rogue.prodigy._problem import Problem
from rogue.prodigy._proof import prove_unsolvable
from rogue.prodigy._result import SearchResult, Status
from rogue.prodigy._rules import RuleSet
from rogue.prodigy._search import Search

FIRST_BOUND, FIRST_NODES = 30, 500
"""PRODIGY's customary depth bound, and the nodes spent on it before it grows."""


def solve(
    problem: Problem,
    options: SearchOptions | None = None,
    rules: RuleSet | None = None,
) -> SearchResult:
    """Search to the end and return the outcome; nothing is executed.

    Depth-first search may lose itself below one bad choice, so the depth bound starts low and
    grows up to that of the options. Nodes and seconds are those of all attempts together, the
    trace is that of the last.

    Raises:
        SequenceError: If ``options`` ask for execution, which needs a caller that executes.
        FunctionError: If a function of the domain raises.
    """
    options = options or SearchOptions()
    if options.execute:
        raise SequenceError("solve() does not execute: drive a Search instead")
    nodes, seconds, proof_states = 0, 0.0, options.proof_states
    for bound, most, is_last in _attempts(options):
        left = None if options.time_limit is None else max(0.0, options.time_limit - seconds)
        share = replace(
            options,
            depth_bound=bound,
            max_nodes=most if most is None else max(1, most - nodes if is_last else most),
            time_limit=left,
            proof_states=proof_states,
        )
        result = _run(problem, share, rules)
        nodes, seconds = nodes + result.nodes, seconds + result.seconds
        if result.status is not Status.LIMIT or is_last or _is_late(options, seconds):
            break
        if "no alternatives" in result.reason:
            proof_states = 0
    result = replace(result, nodes=nodes, seconds=seconds)
    if result.status is Status.LIMIT and proof_states and not _is_late(options, seconds):
        result = _proved(problem, result, proof_states)
    return result


def _proved(problem: Problem, result: SearchResult, states: int) -> SearchResult:
    """Return the outcome of a search that gave up, as unsolvable if that can be proved."""
    world = World(problem.domain, problem.objects, problem.state)
    finish = finish_operator(problem.variables, problem.goal)
    goals = (instance.preconditions for instance in all_instances(finish, world))
    proof = prove_unsolvable(world, goals, states)
    if not proof.is_proved:
        return replace(result, reason=f"{result.reason} ({result.nodes} nodes in all)")
    trace = (*result.trace[:-1], proof.reason) if result.trace else ()
    return replace(
        result,
        status=Status.UNSOLVABLE,
        reason=proof.reason,
        hopeless=proof.hopeless,
        trace=trace,
    )


def _run(problem: Problem, options: SearchOptions, rules: RuleSet | None) -> SearchResult:
    search = Search(problem, options, rules)
    for _ in search.events():
        pass
    assert search.result is not None
    return search.result


def _is_late(options: SearchOptions, seconds: float) -> bool:
    return options.time_limit is not None and seconds >= options.time_limit


def _attempts(options: SearchOptions) -> Iterator[tuple[int | None, int | None, bool]]:
    """Yield depth bound, nodes and whether it is the last attempt."""
    bound, nodes, spent = FIRST_BOUND, FIRST_NODES, 0
    deepest, most = options.depth_bound, options.max_nodes
    while (deepest is None or bound < deepest) and (most is None or spent + nodes < most):
        yield bound, nodes, False
        spent += nodes
        bound, nodes = bound * 3 // 2, nodes * 2
    yield deepest, most, True
