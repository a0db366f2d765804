"""Values of variables, truth of expressions, and the ways to make them true."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from rogue.prodigy._domain import Domain
from rogue.prodigy._errors import FunctionError
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
)
from rogue.prodigy._functions import GEN_FROM_PRED
from rogue.prodigy._state import State
from rogue.prodigy._terms import Atom, Bindings, Literal, Value, Variable
from rogue.prodigy._types import Objects

MOST_GENERATED = 10_000
"""Values that a generator may give for one variable."""


@dataclass(frozen=True, slots=True)
class World:
    """A state together with what is needed to ask questions about it."""

    domain: Domain
    objects: Objects
    state: State

    def values(self, spec: VariableSpec, bindings: Bindings) -> Iterator[Value]:
        """Yield the values of a variable that fit its types and its functions.

        Functions whose arguments are not all bound yet are not asked.
        """
        calls, values = spec.calls, self._candidates(spec, bindings)
        for value in values:
            extended = {**bindings, spec.name: value}
            if all(self.passes(call, extended) for call in calls):
                yield value

    def _candidates(self, spec: VariableSpec, bindings: Bindings) -> Iterable[Value]:
        generators = [c for c in spec.calls if c.function == GEN_FROM_PRED]
        if generators:
            return self.in_order(self._generated(generators[0], spec, bindings))
        if any(name in self.domain.types.infinite for name in spec.types.names):
            return self._infinite(spec, bindings)
        return self.objects.of(spec.types)

    def _generated(self, call: Call, spec: VariableSpec, bindings: Bindings) -> set[Value]:
        assert call.pattern is not None
        found = self.matches(call.pattern, bindings)
        return {m[spec.name] for m in found if self.fits(m[spec.name], spec)}

    def matches(self, pattern: Atom, bindings: Bindings) -> Iterator[dict[str, Value]]:
        """Yield ``bindings`` extended by each true fact that ``pattern`` matches."""
        for args in self.state.tuples(pattern.predicate):
            extended = pattern.match(args, bindings)
            if extended is not None:
                yield extended

    def _infinite(self, spec: VariableSpec, bindings: Bindings) -> Iterable[Value]:
        call = spec.calls[0]
        if not all(v in bindings or v == spec.name for v in _names(call)):
            return ()
        args = tuple(t for t in call.terms if t != Variable(spec.name))
        made = self._call(call.function, tuple(_value(t, bindings) for t in args))
        if not isinstance(made, Iterable):
            raise FunctionError(call.function, args, f"gave {made!r}, expected values")
        values = list(itertools.islice(made, MOST_GENERATED + 1))
        if len(values) > MOST_GENERATED:
            raise FunctionError(call.function, args, f"gave more than {MOST_GENERATED} values")
        return [value for value in values if self.fits(value, spec)]

    def in_order(self, values: Iterable[Value]) -> list[Value]:
        """Return values in the order in which the objects are declared, numbers first."""
        return sorted(values, key=self.objects.position)

    def fits(self, value: Value, spec: VariableSpec) -> bool:
        """Say whether ``value`` is of the types of ``spec``."""
        if self.objects.is_a(value, spec.types):
            return True
        tests = [self.domain.types.infinite.get(name) for name in spec.types.names]
        return any(test is not None and bool(self._call(test, (value,))) for test in tests)

    def passes(self, call: Call, bindings: Bindings) -> bool:
        """Say whether a function test holds; true while an argument is not bound.

        Raises:
            FunctionError: If the function raises.
        """
        if call.pattern is not None:
            return any(True for _ in self.matches(call.pattern, bindings))
        if not all(name in bindings for name in _names(call)):
            return True
        return bool(self._call(call.function, tuple(_value(t, bindings) for t in call.terms)))

    def _call(self, function: str, args: tuple[Value, ...]) -> object:
        try:
            return self.domain.functions[function](*args)
        except Exception as error:
            raise FunctionError(function, args, f"raised {error!r}") from error

    def combinations(
        self, specs: tuple[VariableSpec, ...], bindings: Bindings
    ) -> Iterator[dict[str, Value]]:
        """Yield ``bindings`` extended by every combination of values of ``specs``."""
        free = [spec for spec in specs if spec.name not in bindings]
        if not free:
            yield dict(bindings)
            return
        for value in self.values(free[0], bindings):
            yield from self.combinations(tuple(free[1:]), {**bindings, free[0].name: value})

    def holds(self, expression: Expression, bindings: Bindings) -> bool:
        """Say whether an expression is true."""
        match expression:
            case Holds(atom):
                return self.state.holds(atom.ground(bindings))
            case Not(part):
                return not self.holds(part, bindings)
            case And(parts):
                return all(self.holds(part, bindings) for part in parts)
            case Or(parts):
                return any(self.holds(part, bindings) for part in parts)
            case Exists(variables, body):
                return any(self.holds(body, b) for b in self.combinations(variables, bindings))
            case Forall(variables, body):
                return all(self.holds(body, b) for b in self.combinations(variables, bindings))

    def branches(
        self, expression: Expression, bindings: Bindings, *, positive: bool = True
    ) -> Iterator[tuple[Literal, ...]]:
        """Yield the sets of literals each of which makes the expression true (or false)."""
        match expression:
            case Holds(atom):
                yield (atom.ground(bindings, positive=positive),)
            case Not(part):
                yield from self.branches(part, bindings, positive=not positive)
            case And(parts) | Or(parts):
                each = [self.branches(part, bindings, positive=positive) for part in parts]
                yield from _joined(each, all_of=isinstance(expression, And) == positive)
            case Exists(variables, body) | Forall(variables, body):
                cases = self.combinations(variables, bindings)
                each = [self.branches(body, case, positive=positive) for case in cases]
                yield from _joined(each, all_of=isinstance(expression, Forall) == positive)


def _joined(
    each: list[Iterator[tuple[Literal, ...]]], *, all_of: bool
) -> Iterator[tuple[Literal, ...]]:
    if not all_of:
        yield from itertools.chain.from_iterable(each)
        return
    for combination in itertools.product(*each):
        literals = dict.fromkeys(itertools.chain.from_iterable(combination))
        if not any(literal.negated() in literals for literal in literals):
            yield tuple(literals)


def _names(call: Call) -> Iterator[str]:
    return (term.name for term in call.terms if isinstance(term, Variable))


def _value(term: Variable | Value, bindings: Bindings) -> Value:
    return bindings[term.name] if isinstance(term, Variable) else term
