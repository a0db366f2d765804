"""Parsing of types, variables, atoms and expressions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from rogue.prodigy._errors import close_matches
from rogue.prodigy._expressions import (
    TRUE,
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
from rogue.prodigy._forms import (
    as_form,
    as_list,
    as_word,
    fail,
    first,
    head,
    is_variable,
    number,
    parts,
)
from rogue.prodigy._functions import GEN_FROM_PRED, Function, Generator
from rogue.prodigy._parse_types import COMBINATIONS, parse_type_spec
from rogue.prodigy._reader import Form, Node, Word
from rogue.prodigy._signatures import Signatures
from rogue.prodigy._terms import Atom, Term, Variable
from rogue.prodigy._types import TypeSpec, TypeTree

Scope = frozenset[str]
"""Names of the variables that may be used."""

NEGATIONS = {"~", "not"}
TYPO = 0.75
"""Likeness from which an unknown predicate is taken for a known one, misspelt."""


@dataclass
class Vocabulary:
    """What a text may refer to; predicates are collected while it is read.

    Attributes:
        types: Types of the domain.
        functions: Functions by name.
        predicates: Arity of each predicate seen so far.
        objects: Known objects; None where any name is taken as one.
        closed: Whether a predicate that is not in ``predicates`` is an error.
        signatures: Types that arguments must have, where that is known.
    """

    types: TypeTree
    functions: Mapping[str, Function]
    predicates: dict[str, int] = field(default_factory=dict)
    objects: Mapping[str, str] | None = None
    closed: bool = False
    signatures: Signatures = field(default_factory=dict)

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
            self._check_infinite(word, self.objects)
        return word.text

    def _check_infinite(self, word: Word, objects: Mapping[str, str]) -> None:
        """Fail unless ``word`` is of an infinite type, such as that of all symbols."""
        raised = ""
        for kind, test in self.types.infinite.items():
            try:
                if self.functions[test](word.text):
                    return
            except Exception as error:
                raised = f", or a {kind}, for which {test} raised {error!r}"
        fail(word, f"an object of the problem{raised}", objects)

    def atom(self, node: Node, scope: Scope, *, is_fact: bool = False) -> Atom:
        """Return a predicate with its terms; checks the number of arguments.

        A fact may be of a predicate that nothing else mentions, if it is like no other.
        """
        form = as_form(node, "a literal in parentheses")
        if not head(form):
            fail(form, "the name of a predicate after '('")
        name = head(form)
        terms = tuple(self.term(item, scope) for item in form.items[1:])
        if is_fact:
            self.check_known(form, name, len(terms))
        else:
            self.check_predicate(form, name, len(terms))
            self._check_types(form, name, terms)
        return Atom(name, terms)

    def check_predicate(self, form: Form, name: str, count: int) -> None:
        """Take in that ``form`` gives ``name`` so many arguments, or fail."""
        if self.closed and name not in self.predicates:
            fail(first(form), "a predicate of the domain", self.predicates)
        arity = self.predicates.setdefault(name, count)
        if arity != count:
            fail(form, f"{arity} arguments for {name}, not {count}")

    def _check_types(self, form: Form, name: str, terms: tuple[Term, ...]) -> None:
        """Fail for an object that no operator speaks of in its place."""
        signature = self.signatures.get(name, ())
        for at, (term, members) in enumerate(zip(terms, signature, strict=False), start=1):
            kind = (self.objects or {}).get(term) if isinstance(term, str) else None
            if kind is not None and members is not None and kind not in members:
                wanted = str(self.types.spec(members))
                fail(form.items[at], f"an object of type {wanted} in {name}, not of type {kind}")

    def check_known(self, form: Form, name: str, count: int) -> None:
        """Do as ``check_predicate``, but take in a predicate that is like no other."""
        if name not in self.predicates:
            if close_matches(name, self.predicates, TYPO):
                fail(first(form), "a predicate of the domain", self.predicates)
            self.predicates[name] = count
        self.check_predicate(form, name, count)

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
            return TRUE
        return Holds(self.atom(form, scope))

    def _all(self, nodes: Iterable[Node], scope: Scope) -> tuple[Expression, ...]:
        return tuple(self.expression(node, scope) for node in nodes)

    def _quantified(self, form: Form, scope: Scope) -> Expression:
        declared, body = parts(form, 2, 2, "variables and one expression")
        variables = self.quantified(declared, scope)
        inner = scope | {v.name for v in variables}
        kind = Exists if head(form) == "exists" else Forall
        return kind(variables, self.expression(body, inner))

    def quantified(self, node: Node, scope: Scope) -> tuple[VariableSpec, ...]:
        """Return the variables of a quantifier, which must not hide any of ``scope``."""
        specs = self.variables(node, scope)
        for spec, item in zip(specs, as_list(node, ""), strict=True):
            if spec.name in scope:
                fail(first(as_form(item, "")), "a name that no variable around it has")
        return specs

    def variables(self, node: Node, scope: Scope = frozenset()) -> tuple[VariableSpec, ...]:
        """Return declared variables: ``((<v> TYPE) (<w> (and TYPE (fn <v> <w>))) ...)``."""
        items = as_list(node, "a list of variables ((<v> TYPE) ...)")
        names = [self._declared_name(item) for item in items]
        known = scope | {word.text for word in names}
        specs: dict[str, VariableSpec] = {}
        for word, item in zip(names, items, strict=True):
            if word.text in specs:
                fail(word, "a variable that is not declared twice")
            types, calls = self._declared_type(as_form(item, "(<v> TYPE)").items[1], known)
            specs[word.text] = VariableSpec(word.text, types, calls)
        return tuple(specs.values())

    def _declared_name(self, node: Node) -> Word:
        form = as_form(node, "a variable with its type (<v> TYPE)")
        if len(form.items) != 2 or not is_variable(form.items[0]):
            fail(form, "a variable with its type (<v> TYPE)")
        return as_word(form.items[0], "a variable")

    def _declared_type(self, node: Node, scope: Scope) -> tuple[TypeSpec, tuple[Call, ...]]:
        if not isinstance(node, Form) or head(node) != "and":
            return parse_type_spec(node, self.types), ()
        inner = parts(node, 1, None, "a type and functions after and")
        typed = tuple(n for n in inner if isinstance(n, Word) or head(n) in COMBINATIONS)
        if not typed:
            fail(node, "a type after and", self.types.names())
        together = node.with_items((node.items[0], *typed))
        calls = tuple(self._call(n, scope) for n in inner if n not in typed)
        return parse_type_spec(typed[0] if len(typed) == 1 else together, self.types), calls

    def _call(self, node: Node, scope: Scope) -> Call:
        form = as_form(node, "a function call (function <v> ...)")
        name = head(form)
        if name == GEN_FROM_PRED:
            (pattern,) = parts(form, 1, 1, "one literal after gen-from-pred")
            return Call(name, (), self.atom(pattern, scope))
        self.function(first(form))
        return Call(name, tuple(self.term(item, scope) for item in form.items[1:]))

    def generates(self, call: Call) -> bool:
        """Say whether a call gives values rather than tests them."""
        return call.pattern is not None or isinstance(self.functions[call.function], Generator)

    def function(self, node: Node) -> str:
        """Return the name of a registered function."""
        word = as_word(node, "the name of a function")
        if word.text not in self.functions:
            fail(word, "a registered function", self.functions)
        return word.text
