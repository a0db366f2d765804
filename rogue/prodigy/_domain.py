"""Domains: types, operators, functions and control rules."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING

from rogue.prodigy._expressions import TRUE, Expression, VariableSpec
from rogue.prodigy._functions import Function
from rogue.prodigy._terms import Atom
from rogue.prodigy._types import TypeTree

if TYPE_CHECKING:
    from rogue.prodigy._rules import RuleSet


@dataclass(frozen=True, slots=True)
class Effect:
    """One change: an atom added or deleted.

    Attributes:
        atom: What becomes true or false.
        adds: True for add, False for delete.
        variables: Variables that range over all values of their types.
        condition: Must hold in the state before; TRUE for an unconditional effect.
    """

    atom: Atom
    adds: bool
    variables: tuple[VariableSpec, ...] = ()
    condition: Expression = TRUE


@dataclass(frozen=True, slots=True)
class Operator:
    """An operator schema.

    Attributes:
        name: In lower case.
        params: Variables shown with the name, in order, angle brackets included.
        variables: Declared variables of the preconditions.
        precondition: Must hold before.
        effects: What changes, deletions first.
    """

    name: str
    params: tuple[str, ...]
    variables: tuple[VariableSpec, ...]
    precondition: Expression
    effects: tuple[Effect, ...]

    def all_variables(self) -> tuple[VariableSpec, ...]:
        """Return the variables of the preconditions, then those of the effects, each once."""
        local = (spec for effect in self.effects for spec in effect.variables)
        return tuple(dict.fromkeys((*self.variables, *local)))

    def __str__(self) -> str:
        return self.name


class InferenceMode(StrEnum):
    """When an inference rule fires."""

    EAGER = "eager"
    """Once after every application, without chaining; undone when its support goes."""
    LAZY = "lazy"
    """Back-chained on like an operator, and fired inside its node."""
    STATIC = "static"
    """Once at the root: an eager rule whose conditions change nowhere but in such rules."""


@dataclass(frozen=True, slots=True)
class InferenceRule(Operator):
    """A rule that says what follows from the state; it is no step of a plan.

    Attributes:
        mode: When it fires.
    """

    mode: InferenceMode = InferenceMode.LAZY


@dataclass(frozen=True)
class Domain:
    """A planning domain.

    Attributes:
        name: From the text or the file.
        types: Tree of types.
        operators: In order of definition.
        predicates: Number of arguments of every predicate that operators mention.
        functions: Functions that the domain may call, by name.
        constants: Objects that exist in every problem, with their types.
        rules: The control rules of the text, in order of definition.
        inference_rules: In order of definition.
    """

    name: str
    types: TypeTree
    operators: tuple[Operator, ...]
    predicates: Mapping[str, int]
    functions: Mapping[str, Function] = field(default_factory=dict)
    constants: Mapping[str, str] = field(default_factory=dict)
    rules: RuleSet | None = None
    inference_rules: tuple[InferenceRule, ...] = ()

    @cached_property
    def changed(self) -> frozenset[tuple[str, bool]]:
        """Predicates that may become true (True) or false (False) after the root.

        What a rule infers may also become false, as its support goes; static rules fire at the
        root only.
        """
        made = {(e.atom.predicate, e.adds) for o in self.operators for e in o.effects}
        for rule in self.inference_rules:
            if rule.mode is not InferenceMode.STATIC:
                made.update(
                    (e.atom.predicate, sign) for e in rule.effects for sign in (True, False)
                )
        return frozenset(made)

    def is_static(self, predicate: str) -> bool:
        """Say whether neither operators nor inference rules change ``predicate`` after the root."""
        return (predicate, True) not in self.changed and (predicate, False) not in self.changed

    def operator(self, name: str) -> Operator | None:
        """Return the operator named ``name``, or None."""
        return next((o for o in self.operators if o.name == name), None)

    def inference_rule(self, name: str) -> InferenceRule | None:
        """Return the inference rule named ``name``, or None."""
        return next((r for r in self.inference_rules if r.name == name), None)
