"""Planning without a caller in the loop."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, replace

from rogue.prodigy._budget import OutOfTimeError
from rogue.prodigy._errors import SequenceError, TooManyValuesError
from rogue.prodigy._events import Found, StepView
from rogue.prodigy._grounding import World
from rogue.prodigy._inference import Inference
from rogue.prodigy._instances import all_instances, finish_operator
from rogue.prodigy._options import SearchOptions, Solutions
from rogue.prodigy._problem import Problem
from rogue.prodigy._proof import Proof, proof_budget, prove_unsolvable
from rogue.prodigy._result import Limit, LimitKind, SearchResult, Status
from rogue.prodigy._rules import RuleSet
from rogue.prodigy._search import Search
from rogue.prodigy._solutions import SolutionFilter

FIRST_BOUND, FIRST_NODES = 30, 500
"""PRODIGY's customary depth bound, and the nodes spent on it before it grows."""


@dataclass(frozen=True, slots=True)
class Solution:
    """One of several solutions: its plan, and its number from 1."""

    number: int
    plan: tuple[StepView, ...]


def solve(
    problem: Problem,
    options: SearchOptions | None = None,
    rules: RuleSet | None = None,
    *,
    on_solution: Callable[[Solution], None] | None = None,
    on_end: Callable[[Search], None] | None = None,
) -> SearchResult:
    """Search to the end and return the outcome; nothing is executed.

    Depth-first search may lose itself below one bad choice, so the depth bound starts low and
    grows up to that of the options. Nodes and seconds are those of all attempts together, the
    trace is that of the last; ``on_end`` is called with the last, to look at its tree. Where all
    solutions are asked for, one search does it all; ``on_solution`` is called with each of several.

    Raises:
        SequenceError: If ``options`` ask for execution, which needs a caller that executes.
        FunctionError: If a function of the domain raises.
        InferenceError: If an inference rule hangs on its own absence.
    """
    options = _without_execution(options)
    attempts = _Attempts(problem, options, rules or RuleSet())
    for event in attempts.found():
        if on_solution is not None:
            on_solution(Solution(event.number, event.plan))
    if on_end is not None and attempts.last is not None:
        on_end(attempts.last)
    return attempts.result()


def solutions(
    problem: Problem,
    options: SearchOptions | None = None,
    rules: RuleSet | None = None,
) -> Generator[Solution, None, SearchResult]:
    """Yield solutions as they are found: all, only different or only better ones.

    ``options.solutions`` says which, all of them if it says one. The generator returns the
    result, which says whether a limit ended it. Errors are those of ``solve``.
    """
    options = _without_execution(options)
    if options.solutions is Solutions.ONE:
        options = replace(options, solutions=Solutions.ALL)
    attempts = _Attempts(problem, options, rules or RuleSet())
    for event in attempts.found():
        yield Solution(event.number, event.plan)
    return attempts.result()


def _without_execution(options: SearchOptions | None) -> SearchOptions:
    options = options or SearchOptions()
    if options.execute:
        raise SequenceError("solve() does not execute: drive a Search instead")
    return options


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
        self._solutions = SolutionFilter(options)

    def found(self) -> Iterator[Found]:
        """Search, and yield each of several solutions when it is found."""
        for bound, most, is_last in _bounds(self._options):
            result = yield from self._search(bound, most)
            if self._is_final(result) or is_last:
                break

    def _search(self, bound: int | None, most: int | None) -> Generator[Found, None, SearchResult]:
        limit = self._options.time_limit
        share = replace(
            self._options,
            depth_bound=bound,
            max_nodes=most,
            time_limit=None if limit is None else limit - self._seconds,
            proof_states=0,
        )
        search = Search(self._problem, share, self._rules, known=self._solutions)
        for event in search.events():
            if isinstance(event, Found):
                yield event
        assert search.result is not None
        self._last, self.last = search.result, search
        self._nodes += search.result.nodes
        self._seconds += search.result.seconds
        return search.result

    def _is_final(self, result: SearchResult) -> bool:
        """Say whether another attempt would not do better."""
        if result.limit is None or self._is_late():
            return True
        if self._solutions.count:
            return result.limit.kind not in {LimitKind.NODES, LimitKind.DEPTH}
        if self._proof is None:
            self._proof = self._prove()
        is_exhausted = result.limit.kind not in {LimitKind.NODES, LimitKind.DEPTH}
        return self._proof.is_proved or is_exhausted

    def _is_late(self) -> bool:
        limit = self._options.time_limit
        return limit is not None and self._seconds >= limit

    def _prove(self) -> Proof:
        clock, limit = self._options.clock, self._options.time_limit
        began = clock()

        def is_late() -> bool:
            return limit is not None and self._seconds + clock() - began >= limit

        try:
            return _prove(self._problem, self._options.proof_states, is_late)
        except OutOfTimeError:
            return Proof(False, "whether there is a plan is not known")
        finally:
            self._seconds += clock() - began

    def result(self) -> SearchResult:
        """Return the outcome of all attempts together."""
        assert self._last is not None
        result = replace(self._last, nodes=self._nodes, seconds=self._seconds)
        if result.status is Status.LIMIT and self._proof is not None and self._proof.is_proved:
            return _proved(result, self._proof)
        if result.limit is None:
            return result
        limit = Limit(result.limit.kind, self._value_of(result.limit))
        if result.status is not Status.LIMIT:
            return replace(result, limit=limit)
        more = f"; {self._proof.reason}" if self._proof is not None else ""
        reason = f"{limit}{more}"
        trace = (*result.trace[:-1], reason) if result.trace else ()
        return replace(result, limit=limit, reason=reason, trace=trace)

    def _value_of(self, limit: Limit) -> float:
        """Return the value of a bound that the attempts share."""
        options = self._options
        whole = {
            LimitKind.NODES: options.max_nodes,
            LimitKind.SECONDS: options.time_limit,
            LimitKind.PROOF_STATES: options.proof_states,
        }.get(limit.kind)
        return limit.value if whole is None else whole


def _prove(problem: Problem, states: int, is_late: Callable[[], bool]) -> Proof:
    budget = proof_budget(states, is_late)
    inference = Inference(problem.domain, [problem.goal])
    world = World(problem.domain, problem.objects, problem.state, budget)
    try:
        begun = inference.start(world)
    except TooManyValuesError as error:
        return Proof(False, str(error))
    finish = finish_operator(problem.variables, problem.goal)
    world = world.at(begun.base)
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
    at_once = options.solutions in {Solutions.ALL, Solutions.DIFFERENT}
    while not at_once and _is_below(bound, deepest) and _is_below(spent + nodes, most):
        yield bound, nodes, False
        spent += nodes
        bound, nodes = bound * 3 // 2, nodes * 2
    yield deepest, None if most is None else most - spent, True


def _is_below(value: int, bound: int | None) -> bool:
    return bound is None or value < bound
