"""Functions that a domain may call in the declaration of a variable.

A *test* is any function that gives a truth value; it is called when all its arguments have
values. A *generator*, made with ``generator``, gives the values that a variable may take. It is
called with one argument unbound at most, the variable that it generates for, which then is None;
where the variable has a value already, that value must be among those given.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction

from rogue.prodigy._terms import Value

Function = Callable[..., object]
"""A function that a domain names: a test, or a ``Generator``."""

GEN_FROM_PRED = "gen-from-pred"
"""Generates the values of a variable from true literals; built into the generation of bindings."""

Number = int | float


class Generator:
    """A function that gives the values of a variable, as ``generator`` marks it."""

    __slots__ = ("_function", "name")

    def __init__(self, function: Callable[..., Iterable[Value]]) -> None:
        self._function = function
        self.name = getattr(function, "__name__", type(function).__name__)

    def __call__(self, *args: Value | None) -> Iterable[Value]:
        """Return the values for the argument that is None, or for one that is not among them."""
        return self._function(*args)

    def __repr__(self) -> str:
        return f"<generator {self.name}>"


def generator(function: Callable[..., Iterable[Value]]) -> Generator:
    """Mark a function as one that generates the values of a variable.

    It takes the arguments that the domain writes, in their order, None for the one to generate::

        @generator
        def next_level(level: int | None, above: int | None) -> list[int]:
            return [level + 1] if above is None else [above - 1]

        parse_domain("... (<m> (and level (next-level <n> <m>))) ...",
                     functions={"next-level": next_level})
    """
    return Generator(function)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float)


def _is_integer(value: object) -> bool:
    return isinstance(value, int)


def _is_symbol(value: object) -> bool:
    return isinstance(value, str)


def _plain(value: Fraction) -> Number:
    return value.numerator if value.denominator == 1 else float(value)


def _sum(one: Number, other: Number) -> Number:
    return one + other


def _difference(one: Number, other: Number) -> Number:
    return one - other


def _product(one: Number, other: Number) -> Number:
    return one * other


def _quotient(one: Number, other: Number) -> Number:
    return _plain(Fraction(one) / Fraction(other))


Arithmetic = Callable[[Number, Number], Number]


def _solved(result: Arithmetic, first: Arithmetic, second: Arithmetic) -> Generator:
    """Return the generator of ``(f a b c)`` with c = result(a, b), a = first(c, b), b = second."""

    def values(a: Number | None, b: Number | None, c: Number | None) -> list[Value]:
        try:
            if a is not None and b is not None:
                return [result(a, b)]
            if c is None:
                return []
            if b is not None:
                return [first(c, b)]
            return [] if a is None else [second(a, c)]
        except ZeroDivisionError:
            return []

    return Generator(values)


def _stepped(step: int) -> Generator:
    def values(n: Number | None, m: Number | None) -> list[Value]:
        if n is not None:
            return [n + step]
        return [] if m is None else [m - step]

    return Generator(values)


def _between(low: int, high: int, n: int | None = None) -> Iterable[Value]:
    return range(low, high + 1) if n is None else [n] if low <= n <= high else []


BUILT_IN: Mapping[str, Function] = {
    "diff": operator.ne,
    "same": operator.eq,
    "equal": operator.eq,
    "=": operator.eq,
    "/=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "numberp": _is_number,
    "integerp": _is_integer,
    "symbolp": _is_symbol,
    "add": _solved(_sum, _difference, lambda a, c: c - a),
    "subtract": _solved(_difference, _sum, _difference),
    "multiply": _solved(_product, _quotient, lambda a, c: _quotient(c, a)),
    "divide": _solved(_quotient, _product, _quotient),
    "increment": _stepped(1),
    "decrement": _stepped(-1),
    "between": Generator(_between),
}
"""The functions that every domain may call without registering them."""
