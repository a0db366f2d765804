"""Values of variables, truth of expressions, and the ways to make them true."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from rogue.prodigy._budget import Budget
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
    Requirement,
    VariableSpec,
    required,
)
from rogue.prodigy._functions import Generator
from rogue.prodigy._state import State
from rogue.prodigy._terms import Atom, Bindings, Literal, Value, Variable
from rogue.prodigy._types import Objects

MOST_GENERATED = 10_000
"""Values that a generator may give for one variable."""

Given = tuple[Requirement, ...]
"""Literals that must hold now; only values with which they can are of interest."""


@dataclass(frozen=True, slots=True)
class World:
    """A state together with what is needed to ask questions about it.

    With a budget, questions that take too many values end with one of its errors.
    """

    domain: Domain
    objects: Objects
    state: State
    budget: Budget | None = None

    def at(self, state: State) -> World:
        """Return the same with another state."""
        return World(self.domain, self.objects, state, self.budget)

    def combinations(
        self,
        specs: tuple[VariableSpec, ...],
        bindings: Bindings,
        given: Given = (),
        hints: Given = (),
    ) -> Iterator[dict[str, Value]]:
        """Yield ``bindings`` extended by every combination of values of ``specs``.

        Variables take their values in the order declared, but after those that their functions
        ask for. Every function is asked as soon as all its arguments have values.

        Args:
            specs: The variables; those that ``bindings`` has are only checked.
            bindings: What is bound already.
            given: What must hold now.
            hints: Whose facts have the values of a variable of infinite type that neither a
                generator nor ``given`` knows.
        """
        free = tuple(spec for spec in specs if spec.name not in bindings)
        bound = [(call, s) for s in specs if s.name in bindings for call in s.calls]
        if all(self._may_hold(r, bindings) for r in given):
            yield from self._extended(free, dict(bindings), (given, hints), bound)

    def _extended(
        self,
        free: tuple[VariableSpec, ...],
        bindings: dict[str, Value],
        known: tuple[Given, Given],
        unasked: list[tuple[Call, VariableSpec]],
    ) -> Iterator[dict[str, Value]]:
        waiting: list[tuple[Call, VariableSpec]] = []
        for call, asking in unasked:
            if not _is_ready(call, asking, bindings):
                waiting.append((call, asking))
            elif not self.passes(call, asking, bindings):
                return
        if not free:
            yield bindings
            return
        spec = _next_variable(free, bindings)
        others = tuple(s for s in free if s is not spec)
        mine, hints = (tuple(r for r in g if spec.name in r.variables) for g in known)
        generating, values = self._candidates(spec, bindings, mine, hints)
        waiting.extend((call, spec) for call in spec.calls if call is not generating)
        for value in values:
            if self.budget is not None:
                self.budget.spend()
            extended = {**bindings, spec.name: value}
            if all(self._may_hold(r, extended) for r in mine):
                yield from self._extended(others, extended, known, waiting)

    def _may_hold(self, requirement: Requirement, bindings: Bindings) -> bool:
        if not all(name in bindings for name in requirement.variables):
            return True
        return self.state.holds(requirement.atom.ground(bindings, positive=requirement.positive))

    def _candidates(
        self, spec: VariableSpec, bindings: Bindings, given: Given, hints: Given
    ) -> tuple[Call | None, Iterable[Value]]:
        """Return the values to try, and the function that needs not be asked of them again."""
        for call in spec.calls:
            if call.pattern is not None and spec.name in call.variables():
                is_whole = _is_ready(call, spec, bindings)
                return (call if is_whole else None), self._in_facts(spec, [call.pattern], bindings)
            if self.is_generator(call) and _is_ready(call, spec, bindings):
                values = self._generated(call, spec, bindings)
                return call, [value for value in values if self.fits(value, spec)]
        atoms = [r.atom for r in given if r.positive]
        if self.domain.types.infinite_of(spec.types):
            atoms = atoms or [r.atom for r in hints if r.positive]
            return None, self._in_facts(spec, atoms, bindings)
        objects = self.objects.of(spec.types)
        few = [a for a in atoms if self._size(a, bindings) < len(objects)]
        return None, self._in_facts(spec, few, bindings) if few else objects

    def _in_facts(self, spec: VariableSpec, atoms: list[Atom], bindings: Bindings) -> list[Value]:
        """Return the values that the variable has in facts of the rarest of ``atoms``."""
        if not atoms:
            return []
        atom = min(atoms, key=lambda a: self._size(a, bindings))
        found = {match[spec.name] for match in self.matches(atom, bindings)}
        return self.in_order(value for value in found if self.fits(value, spec))

    def _size(self, atom: Atom, bindings: Bindings) -> int:
        return len(self.state.matching(atom.predicate, atom.pattern(bindings)))

    def matches(self, pattern: Atom, bindings: Bindings) -> Iterator[dict[str, Value]]:
        """Yield ``bindings`` extended by each true fact that ``pattern`` matches."""
        for args in self.state.matching(pattern.predicate, pattern.pattern(bindings)):
            extended = pattern.match(args, bindings)
            if extended is not None:
                yield extended

    def in_order(self, values: Iterable[Value]) -> list[Value]:
        """Return values in the order in which the objects are declared, numbers first."""
        return sorted(values, key=self.objects.position)

    def fits(self, value: Value, spec: VariableSpec) -> bool:
        """Say whether ``value`` is of the types of ``spec``."""
        if self.objects.is_a(value, spec.types):
            return True
        infinite = self.domain.types.infinite
        names = self.domain.types.infinite_of(spec.types)
        return any(bool(self._call(infinite[name], (value,))) for name in names)

    def is_generator(self, call: Call) -> bool:
        """Say whether a call names a generator, not a test."""
        return isinstance(self.domain.functions.get(call.function), Generator)

    def passes(self, call: Call, spec: VariableSpec, bindings: Bindings) -> bool:
        """Say whether a function of ``spec`` holds; true while an argument is not bound.

        Raises:
            FunctionError: If the function raises.
        """
        if call.pattern is not None:
            return any(True for _ in self.matches(call.pattern, bindings))
        if not all(name in bindings for name in call.variables()):
            return True
        if self.is_generator(call):
            return bindings[spec.name] in self._generated(call, spec, bindings)
        return bool(self._call(call.function, tuple(_value(t, bindings) for t in call.terms)))

    def _generated(self, call: Call, spec: VariableSpec, bindings: Bindings) -> list[Value]:
        own = Variable(spec.name)
        args = tuple(None if t == own else _value(t, bindings) for t in call.terms)
        made = self._call(call.function, args)
        if not isinstance(made, Iterable) or isinstance(made, str):
            raise FunctionError(call.function, args, f"gave {made!r}, expected values")
        try:
            values = list(itertools.islice(made, MOST_GENERATED + 1))
        except Exception as error:
            raise FunctionError(call.function, args, f"raised {error!r}") from error
        if len(values) > MOST_GENERATED:
            raise FunctionError(call.function, args, f"gave more than {MOST_GENERATED} values")
        for value in values:
            if isinstance(value, bool) or not isinstance(value, Value):
                raise FunctionError(call.function, args, f"gave {value!r}, expected a value")
        return values

    def _call(self, function: str, args: tuple[Value | None, ...]) -> object:
        try:
            return self.domain.functions[function](*args)
        except Exception as error:
            raise FunctionError(function, args, f"raised {error!r}") from error

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
                cases = self.combinations(variables, bindings, required(body))
                return any(self.holds(body, case) for case in cases)
            case Forall(variables, body):
                cases = self.combinations(variables, bindings, required(body, positive=False))
                return all(self.holds(body, case) for case in cases)

    def static(self, expression: Expression, *, positive: bool = True) -> Given:
        """Return what must hold for ``expression`` to be true (or false) and never changes."""
        needs = required(expression, positive=positive)
        return tuple(r for r in needs if self.domain.is_static(r.atom.predicate))

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
                all_of = isinstance(expression, And) == positive
                yield from _joined(each, self.budget, all_of=all_of)
            case Exists(variables, body) | Forall(variables, body):
                some = isinstance(expression, Exists) == positive
                given = self.static(body, positive=positive if some else not positive)
                cases = self.combinations(variables, bindings, given)
                each = [self.branches(body, case, positive=positive) for case in cases]
                yield from _joined(each, self.budget, all_of=not some)


def _joined(
    each: list[Iterator[tuple[Literal, ...]]], budget: Budget | None, *, all_of: bool
) -> Iterator[tuple[Literal, ...]]:
    if not all_of:
        yield from itertools.chain.from_iterable(each)
        return
    for combination in itertools.product(*each):
        if budget is not None:
            budget.spend()
        literals = dict.fromkeys(itertools.chain.from_iterable(combination))
        if not any(literal.negated() in literals for literal in literals):
            yield tuple(literals)


def _next_variable(free: tuple[VariableSpec, ...], bindings: Bindings) -> VariableSpec:
    ready = (spec for spec in free if all(_is_ready(call, spec, bindings) for call in spec.calls))
    return next(ready, free[0])


def _is_ready(call: Call, spec: VariableSpec, bindings: Bindings) -> bool:
    return all(name in bindings or name == spec.name for name in call.variables())


def _value(term: Variable | Value, bindings: Bindings) -> Value:
    return bindings[term.name] if isinstance(term, Variable) else term
