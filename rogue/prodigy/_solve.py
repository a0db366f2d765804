"""Planning without a caller in the loop."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from rogue.prodigy._errors import SequenceError
from rogue.prodigy._grounding import World
from rogue.prodigy._inference import Inference
from rogue.prodigy._instances import all_instances, finish_operator
from rogue.prodigy._options import SearchOptions
from rogue.prodigy._problem import Problem
from rogue.prodigy._proof import Proof, prove_unsolvable
from rogue.prodigy._result import SearchResult, Status
from rogue.prodigy._rules import RuleSet
from rogue.prodigy._search import Search

FIRST_BOUND, FIRST_NODES = 30, 500
"""PRODIGY's customary depth bound, and the nodes spent on it before it grows."""


def solve(
    problem: Problem,
    options: SearchOptions | None = None,
    rules: RuleSet | None = None,
    *,
    on_end: Callable[[Search], None] | None = None,
) -> SearchResult:
    """Search to the end and return the outcome; nothing is executed.

    Depth-first search may lose itself below one bad choice, so the depth bound starts low and
    grows up to that of the options. Nodes and seconds are those of all attempts together, the
    trace is that of the last; ``on_end`` is called with the last, to look at its tree.

    Raises:
        SequenceError: If ``options`` ask for execution, which needs a caller that executes.
        FunctionError: If a function of the domain raises.
    """
    options = options or SearchOptions()
    if options.execute:
        raise SequenceError("solve() does not execute: drive a Search instead")
    attempts = _Attempts(problem, options, rules or RuleSet())
    for bound, most, is_last in _bounds(options):
        if attempts.search(bound, most) or is_last:
            break
    if on_end is not None and attempts.last is not None:
        on_end(attempts.last)
    return attempts.result()


class _Attempts:
    """Searches of one problem with ever higher bounds; ``last`` is the newest."""

    def __init__(self, problem: Problem, options: SearchOptions, rules: RuleSet) -> None:
        self._problem = problem
        self._options = options
        self._rules = rules
        self._nodes = 0
        self._seconds = 0.0
        self._proof: Proof | None = None
        self._last: SearchResult | None = None
        self.last: Search | None = None

    def search(self, bound: int | None, most: int | None) -> bool:
        """Search once; True if another attempt would not do better."""
        limit = self._options.time_limit
        share = replace(
            self._options,
            depth_bound=bound,
            max_nodes=most,
            time_limit=None if limit is None else limit - self._seconds,
            proof_states=0,
        )
        search = Search(self._problem, share, self._rules)
        for _ in search.events():
            pass
        assert search.result is not None
        self._last, self.last = search.result, search
        self._nodes += search.result.nodes
        self._seconds += search.result.seconds
        return self._is_final(search.result) or _is_exhausted(search)

    def _is_final(self, result: SearchResult) -> bool:
        limit = self._options.time_limit
        if result.status is not Status.LIMIT or (limit is not None and self._seconds >= limit):
            return True
        if self._proof is None:
            self._proof = _prove(self._problem, self._options.proof_states)
        return self._proof.is_proved

    def result(self) -> SearchResult:
        """Return the outcome of all attempts together."""
        assert self._last is not None
        result = replace(self._last, nodes=self._nodes, seconds=self._seconds)
        if result.status is not Status.LIMIT or self._proof is None:
            return result
        if self._proof.is_proved:
            return _proved(result, self._proof)
        return replace(result, reason=f"{result.reason}; {self._proof.reason}")


def _is_exhausted(search: Search) -> bool:
    """Say whether nothing is left to try, with no branch cut at the depth bound."""
    most = search.options.max_nodes
    was_cut = any(node.failure.startswith("hit depth bound") for node in search.nodes())
    return not was_cut and (most is None or len(search.nodes()) < most)


def _prove(problem: Problem, states: int) -> Proof:
    inference = Inference(problem.domain, [problem.goal])
    begun = inference.start(problem.state, problem.objects)
    world = World(problem.domain, problem.objects, begun.base)
    finish = finish_operator(problem.variables, problem.goal)
    goals = (instance.preconditions for instance in all_instances(finish, world))
    return prove_unsolvable(world, goals, states, inference, begun)


def _proved(result: SearchResult, proof: Proof) -> SearchResult:
    trace = (*result.trace[:-1], proof.reason) if result.trace else ()
    return replace(
        result,
        status=Status.UNSOLVABLE,
        reason=proof.reason,
        hopeless=proof.hopeless,
        trace=trace,
    )


def _bounds(options: SearchOptions) -> Iterator[tuple[int | None, int | None, bool]]:
    """Yield depth bound, nodes and whether it is the last attempt."""
    bound, nodes, spent = FIRST_BOUND, FIRST_NODES, 0
    deepest, most = options.depth_bound, options.max_nodes
    while (deepest is None or bound < deepest) and (most is None or spent + nodes < most):
        yield bound, nodes, False
        spent += nodes
        bound, nodes = bound * 3 // 2, nodes * 2
    yield deepest, None if most is None else most - spent, True
