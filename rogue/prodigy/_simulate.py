"""What a plan does, worked out from the text of the domain without any of the search's code.

Slow and plain on purpose: expressions are evaluated as written, effects and inference rules are
tried for every object.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from rogue.prodigy._domain import InferenceMode, InferenceRule, Operator
from rogue.prodigy._expressions import (
    And,
    Call,
    Exists,
    Expression,
    Forall,
    Holds,
    Not,
    Or,
    VariableSpec,
    atoms,
)
from rogue.prodigy._functions import Generator
from rogue.prodigy._problem import Problem
from rogue.prodigy._terms import Literal, Term, Value, Variable

Fact = tuple[str, tuple[Value, ...]]
Facts = frozenset[Fact]
Signed = frozenset[tuple[Fact, bool]]


@dataclass(frozen=True, slots=True)
class SimulatedWorld:
    """What is so at a point of a plan.

    Attributes:
        base: What operators and static rules made.
        facts: All that is true.
        eager: What eager rules said, and whether it is that something is true or false.
    """

    base: Facts
    facts: Facts
    eager: Signed = frozenset()


def start(problem: Problem) -> SimulatedWorld:
    """Return what is so before the first step."""
    facts = frozenset((f.predicate, f.args) for f in problem.state.facts())
    base, _ = _closure(problem, facts, _rules(problem, InferenceMode.STATIC))
    return _world(problem, base, frozenset())


def after(
    problem: Problem, world: SimulatedWorld, operator: Operator, bindings: dict[str, Value]
) -> SimulatedWorld:
    """Return what is so after a step."""
    changed = _with(world.base, _changes(problem, world.facts, operator, bindings))
    return _world(problem, changed, world.eager)


def _world(problem: Problem, base: Facts, said: Signed) -> SimulatedWorld:
    eager = _rules(problem, InferenceMode.EAGER)
    facts, kept = _closure(problem, base, eager, only=said)
    kept |= {one for rule in eager for one in _says(problem, facts, rule)}
    everything, _ = _closure(problem, _with(base, kept), _rules(problem, InferenceMode.LAZY))
    return SimulatedWorld(base, everything, kept)


def _rules(problem: Problem, mode: InferenceMode) -> list[InferenceRule]:
    return [rule for rule in problem.domain.inference_rules if rule.mode is mode]


def _closure(
    problem: Problem, base: Facts, rules: list[InferenceRule], *, only: Signed | None = None
) -> tuple[Facts, Signed]:
    """Return what is so once nothing new follows, what is asked to be absent worked out first."""
    found: set[tuple[Fact, bool]] = set()
    facts = base
    ranks = _ranks(rules)
    for rank in sorted(set(ranks.values())):
        layer = [rule for rule in rules if ranks[rule.name] == rank]
        while True:
            said = {one for rule in layer for one in _says(problem, facts, rule)}
            new = (said if only is None else said & only) - found
            if not new:
                break
            found |= new
            facts = _with(base, found)
    return facts, frozenset(found)


def _ranks(rules: list[InferenceRule]) -> dict[str, int]:
    """Return for each rule how many negations lie below what it says."""
    heads = {rule.name: {effect.atom.predicate for effect in rule.effects} for rule in rules}
    ranks = dict.fromkeys(heads, 0)
    for _ in range(len(rules) ** 2 + 1):
        before = dict(ranks)
        for rule in rules:
            for other in rules:
                wanted, unwanted = _asked(rule)
                if heads[other.name] & (wanted | heads[rule.name]):
                    ranks[rule.name] = max(ranks[rule.name], ranks[other.name])
                if heads[other.name] & unwanted:
                    ranks[rule.name] = max(ranks[rule.name], ranks[other.name] + 1)
        if ranks == before:
            break
    return ranks


def _asked(rule: InferenceRule) -> tuple[set[str], set[str]]:
    conditions = (rule.precondition, *(effect.condition for effect in rule.effects))
    everything = {atom.predicate for c in conditions for atom in atoms(c)}
    unwanted = {name for c in conditions for name in _below_not(c, negated=False)}
    return everything, unwanted


def _below_not(expression: Expression, *, negated: bool) -> Iterator[str]:
    match expression:
        case Holds(atom):
            if negated:
                yield atom.predicate
        case Not(part):
            yield from _below_not(part, negated=not negated)
        case And(parts) | Or(parts):
            for part in parts:
                yield from _below_not(part, negated=negated)
        case Exists(_, part) | Forall(_, part):
            yield from _below_not(part, negated=negated)


def _says(problem: Problem, facts: Facts, rule: InferenceRule) -> Iterator[tuple[Fact, bool]]:
    for case in cases(problem, facts, rule.variables, {}):
        if holds(problem, facts, rule.precondition, case):
            yield from _changes(problem, facts, rule, case)


def _changes(
    problem: Problem, facts: Facts, operator: Operator, bindings: dict[str, Value]
) -> set[tuple[Fact, bool]]:
    made: set[tuple[Fact, bool]] = set()
    for effect in operator.effects:
        free = tuple(v for v in effect.variables if v.name not in bindings)
        for case in cases(problem, facts, free, bindings):
            if holds(problem, facts, effect.condition, case):
                made.add((_fact(effect.atom.ground(case)), effect.adds))
    return made


def _fact(literal: Literal) -> Fact:
    return literal.predicate, literal.args


def _with(facts: Facts, said: Iterable[tuple[Fact, bool]]) -> Facts:
    said = list(said)
    gone = {fact for fact, is_true in said if not is_true}
    return (facts - gone) | {fact for fact, is_true in said if is_true}


def is_of(problem: Problem, spec: VariableSpec, value: Value) -> bool:
    """Say whether a value is of the types of a variable."""
    infinite, functions = problem.domain.types.infinite, problem.domain.functions
    tests = (functions[infinite[name]] for name in spec.types.names if name in infinite)
    return problem.objects.is_a(value, spec.types) or any(test(value) for test in tests)


def passes(
    problem: Problem, facts: Facts, call: Call, spec: VariableSpec, case: dict[str, Value]
) -> bool:
    """Say whether a function of a variable holds of its value."""
    if call.pattern is not None:
        return _fact(call.pattern.ground(case)) in facts
    function = problem.domain.functions[call.function]
    if not isinstance(function, Generator):
        return bool(function(*(_value(t, case) for t in call.terms)))
    own = Variable(spec.name)
    args = (None if t == own else _value(t, case) for t in call.terms)
    return case[spec.name] in function(*args)


def cases(
    problem: Problem,
    facts: Facts,
    specs: tuple[VariableSpec, ...],
    bindings: dict[str, Value],
) -> Iterator[dict[str, Value]]:
    """Yield ``bindings`` extended by every combination of values of ``specs``."""
    found = [bindings]
    for spec in specs:
        found = [
            {**case, spec.name: value}
            for case in found
            for value in _domain_of(problem, facts, spec, case)
        ]
    for case in found:
        if all(passes(problem, facts, c, s, case) for s in specs for c in s.calls):
            yield case


def _domain_of(
    problem: Problem, facts: Facts, spec: VariableSpec, case: dict[str, Value]
) -> Iterator[Value]:
    yield from problem.objects.of(spec.types)
    if any(name in problem.domain.types.infinite for name in spec.types.names):
        known = dict.fromkeys(value for _, args in facts for value in args)
        for call in spec.calls:
            function = problem.domain.functions.get(call.function)
            if isinstance(function, Generator):
                own = Variable(spec.name)
                args = (None if t == own else _value(t, case) for t in call.terms)
                known.update(dict.fromkeys(function(*args)))
        yield from (v for v in known if v not in problem.objects and is_of(problem, spec, v))


def _value(term: Term, bindings: dict[str, Value]) -> Value:
    return bindings[term.name] if isinstance(term, Variable) else term


def holds(
    problem: Problem, facts: Facts, expression: Expression, bindings: dict[str, Value]
) -> bool:
    """Say whether an expression is true, as written."""
    match expression:
        case Holds(atom):
            return _fact(atom.ground(bindings)) in facts
        case Not(part):
            return not holds(problem, facts, part, bindings)
        case And(parts):
            return all(holds(problem, facts, part, bindings) for part in parts)
        case Or(parts):
            return any(holds(problem, facts, part, bindings) for part in parts)
        case Exists(specs, body):
            some = cases(problem, facts, specs, bindings)
            return any(holds(problem, facts, body, case) for case in some)
        case Forall(specs, body):
            every = cases(problem, facts, specs, bindings)
            return all(holds(problem, facts, body, case) for case in every)
