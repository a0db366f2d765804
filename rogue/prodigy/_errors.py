"""Errors of the planner library; each carries its facts and builds its own sentence."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass


class ProdigyError(Exception):
    """Root of the errors of this package."""


@dataclass(frozen=True, slots=True)
class Position:
    """A place in a text: file name, line and column from 1."""

    file: str
    line: int
    column: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


_LONGEST = 80


def close_matches(name: str, known: Iterable[str], cutoff: float = 0.6) -> tuple[str, ...]:
    """Return at most three of ``known`` that are like ``name``, the likest first."""
    if len(name) > _LONGEST:
        return ()
    return tuple(difflib.get_close_matches(name, list(known), n=3, cutoff=cutoff))


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return ``"; did you mean a or b?"`` for the names in ``known`` near ``name``, or ""."""
    near = close_matches(name, known)
    return f"; did you mean {' or '.join(near)}?" if near else ""


def _shortened(text: str) -> str:
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."


class PdlError(ProdigyError):
    """A text that is no valid domain, problem or literal.

    Attributes:
        position: Where.
        found: What stands there, its beginning if it is long.
        expected: What could stand there.
        near: Known names near the one found.
    """

    def __init__(
        self, position: Position, found: str, expected: str, known: Iterable[str] = ()
    ) -> None:
        self.position = position
        self.found = _shortened(found)
        self.expected = expected
        self.near = close_matches(found, known)
        hint = f"; did you mean {' or '.join(self.near)}?" if self.near else ""
        super().__init__(f"{position}: found {self.found}, expected {expected}{hint}")


class UnknownNameError(ProdigyError):
    """A name given by a program that the domain or problem does not know."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        self.kind = kind
        self.name = name
        self.known = tuple(known)
        super().__init__(f"no {kind} named {name!r}{did_you_mean(name, self.known)}")


class LiteralError(ProdigyError):
    """A literal given by a program that does not fit the domain."""

    def __init__(self, literal: object, expected: str) -> None:
        self.literal = literal
        self.expected = expected
        super().__init__(f"{literal} does not fit the domain: expected {expected}")


class FunctionError(ProdigyError):
    """A registered function raised, or gave what it must not give."""

    def __init__(self, function: str, args: tuple[object, ...], problem: str) -> None:
        self.function = function
        self.arguments = args
        self.problem = problem
        shown = " ".join(map(str, args))
        super().__init__(f"function ({function} {shown}) {problem}")


class TooManyValuesError(ProdigyError):
    """One question to the domain took more values of variables than ``max_bindings`` allows.

    Within a search it ends the search at that limit, or only the operator to be bound.
    """

    def __init__(self, most: int) -> None:
        self.most = most
        super().__init__(f"more than {most} values of variables were tried in one step")


class InferenceError(ProdigyError):
    """Inference rules of which one says something because it is not said."""

    def __init__(self, rules: tuple[str, ...]) -> None:
        self.rules = rules
        named = ", ".join(rules)
        super().__init__(f"among the inference rules {named} one hangs on its own absence")


class SequenceError(ProdigyError):
    """A search was driven in the wrong order, such as stepping before an outcome was given."""
