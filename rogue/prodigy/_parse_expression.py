"""Parsing of types, variables, atoms and expressions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from rogue.prodigy._domain import Function
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
from rogue.prodigy._forms import as_form, as_word, fail, head, is_variable, number, parts
from rogue.prodigy._functions import GEN_FROM_PRED
from rogue.prodigy._reader import Form, Node, Word
from rogue.prodigy._terms import Atom, Term, Variable
from rogue.prodigy._types import TOP_TYPE, TypeSpec, TypeTree

Scope = frozenset[str]
"""Names of the variables that may be used."""

NEGATIONS = {"~", "not"}
CONNECTIVES = {"and", "or", "exists", "forall", *NEGATIONS}


@dataclass
class Vocabulary:
    """What a text may refer to; predicates are collected while it is read.

    Attributes:
        types: Types of the domain.
        functions: Functions by name.
        predicates: Arity of each predicate seen so far.
        objects: Known objects; None where any name is taken as one.
        closed: Whether a predicate that is not in ``predicates`` is an error.
    """

    types: TypeTree
    functions: Mapping[str, Function]
    predicates: dict[str, int] = field(default_factory=dict)
    objects: Mapping[str, str] | None = None
    closed: bool = False

    def term(self, node: Node, scope: Scope) -> Term:
        """Return a variable of ``scope``, an object or a number."""
        word = as_word(node, "a variable, an object or a number")
        if is_variable(word):
            if word.text not in scope:
                fail(word, "a variable that is declared", scope)
            return Variable(word.text)
        value = number(word.text)
        if value is not None:
            return value
        if self.objects is not None and word.text not in self.objects:
            fail(word, "an object of the problem", self.objects)
        return word.text

    def atom(self, node: Node, scope: Scope) -> Atom:
        """Return a predicate with its terms; checks the number of arguments."""
        form = as_form(node, "a literal in parentheses")
        if not head(form):
            fail(form, "the name of a predicate after '('")
        name = head(form)
        terms = tuple(self.term(item, scope) for item in form.items[1:])
        if self.closed and name not in self.predicates:
            fail(form.items[0], "a predicate of the domain", self.predicates)
        arity = self.predicates.setdefault(name, len(terms))
        if arity != len(terms):
            fail(form, f"{arity} arguments for {name}, not {len(terms)}")
        return Atom(name, terms)

    def expression(self, node: Node, scope: Scope) -> Expression:
        """Return a logical expression."""
        form = as_form(node, "an expression in parentheses")
        match head(form):
            case "and":
                return And(self._all(form.items[1:], scope))
            case "or":
                return Or(self._all(form.items[1:], scope))
            case word if word in NEGATIONS:
                (part,) = parts(form, 1, 1, f"one expression after {word}")
                return Not(self.expression(part, scope))
            case "exists" | "forall":
                return self._quantified(form, scope)
        if not form.items:
            return And()
        return Holds(self.atom(form, scope))

    def _all(self, nodes: Iterable[Node], scope: Scope) -> tuple[Expression, ...]:
        return tuple(self.expression(node, scope) for node in nodes)

    def _quantified(self, form: Form, scope: Scope) -> Expression:
        declared, body = parts(form, 2, 2, "variables and one expression")
        variables = self.variables(declared, scope)
        inner = scope | {v.name for v in variables}
        kind = Exists if head(form) == "exists" else Forall
        return kind(variables, self.expression(body, inner))

    def variables(self, node: Node, scope: Scope = frozenset()) -> tuple[VariableSpec, ...]:
        """Return declared variables: ``((<v> TYPE) (<w> (and TYPE (fn <v> <w>))) ...)``."""
        form = as_form(node, "a list of variables ((<v> TYPE) ...)")
        names = [self._declared_name(item) for item in form.items]
        known = scope | {word.text for word in names}
        specs: dict[str, VariableSpec] = {}
        for word, item in zip(names, form.items, strict=True):
            if word.text in specs:
                fail(word, "a variable that is not declared twice")
            specs[word.text] = self._variable(as_form(item, "(<v> TYPE)"), known)
        return tuple(specs.values())

    def _declared_name(self, node: Node) -> Word:
        form = as_form(node, "a variable with its type (<v> TYPE)")
        if len(form.items) != 2 or not is_variable(form.items[0]):
            fail(form, "a variable with its type (<v> TYPE)")
        return as_word(form.items[0], "a variable")

    def _variable(self, form: Form, scope: Scope) -> VariableSpec:
        name, spec = as_word(form.items[0], "a variable").text, form.items[1]
        if isinstance(spec, Form) and head(spec) == "and":
            first, *rest = parts(spec, 1, None, "a type and functions after and")
            calls = tuple(self._call(node, scope) for node in rest)
            types = self.type_spec(first)
        else:
            types, calls = self.type_spec(spec), ()
        self._check_generator(form, types, calls)
        return VariableSpec(name, types, calls)

    def _check_generator(self, form: Form, types: TypeSpec, calls: tuple[Call, ...]) -> None:
        infinite = [name for name in types.names if name in self.types.infinite]
        if infinite and not calls:
            fail(form, f"a generator function, because {infinite[0]} is infinite")

    def type_spec(self, node: Node) -> TypeSpec:
        """Return the types that ``TYPE`` or ``(or A B)`` or ``(not A)`` names."""
        if isinstance(node, Word):
            name = node.text.removeprefix(":")
            if name not in self.types:
                fail(node, "a type of the domain", self.types.names())
            return TypeSpec((name,))
        if head(node) not in {"or", "not"} or len(node.items) < 2:
            fail(node, "a type, (or TYPE ...) or (and TYPE (function ...))")
        names = tuple(n for item in node.items[1:] for n in self.type_spec(item).names)
        return TypeSpec(names) if head(node) == "or" else TypeSpec((TOP_TYPE,), names)

    def _call(self, node: Node, scope: Scope) -> Call:
        form = as_form(node, "a function call (function <v> ...)")
        name = head(form)
        if name == GEN_FROM_PRED:
            (pattern,) = parts(form, 1, 1, "one literal after gen-from-pred")
            return Call(name, (), self.atom(pattern, scope))
        self.function(form.items[0] if form.items else form)
        return Call(name, tuple(self.term(item, scope) for item in form.items[1:]))

    def function(self, node: Node) -> str:
        """Return the name of a registered function."""
        word = as_word(node, "the name of a function")
        if word.text not in self.functions:
            fail(word, "a registered function", self.functions)
        return word.text
