"""Parsing of the conditions of control rules, and of the patterns in them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from rogue.prodigy._conditions import Condition, all_of, any_of, asked, none_of
from rogue.prodigy._domain import Operator
from rogue.prodigy._forms import as_form, as_word, fail, first, head, is_variable, number, parts
from rogue.prodigy._functions import Generator
from rogue.prodigy._lisp import unquoted
from rogue.prodigy._meta_predicates import BUILT_IN, Kind, MetaPredicate, ask_test, ask_user
from rogue.prodigy._parse_expression import NEGATIONS, Vocabulary
from rogue.prodigy._parse_types import parse_type_spec
from rogue.prodigy._patterns import BindingsPattern, ListPattern, OneOf, Pattern
from rogue.prodigy._reader import Form, Node, Word
from rogue.prodigy._terms import Term, Variable
from rogue.prodigy._types import TypeSpec

KNOWN = {"known", "true-in-state"}
"""Meta-predicates of which the argument may join several literals."""


@dataclass(frozen=True, slots=True)
class ConditionReader:
    """What the rules of a domain may refer to.

    Attributes:
        words: Types and predicates.
        operators: Operators and inference rules, by name.
        functions: Meta-predicates of the user, by name in lower case.
    """

    words: Vocabulary
    operators: Mapping[str, Operator]
    functions: Mapping[str, MetaPredicate]

    def condition(self, node: Node) -> Condition:
        """Return what an expression of meta-predicates asks."""
        form = as_form(node, "a meta-predicate in parentheses")
        word = head(form)
        if word in {"and", "or"}:
            each = [self.condition(item) for item in form.items[1:]]
            return all_of(each) if word == "and" else any_of(each)
        if word in NEGATIONS:
            (inner,) = parts(form, 1, 1, f"one expression after {word}")
            return none_of(self.condition(inner))
        return self._asked(form, unquoted(as_word(first(form), "a meta-predicate")))

    def _asked(self, form: Form, word: str) -> Condition:
        if word in self.functions:
            arguments = tuple(self.argument(item, Kind.ANY) for item in form.items[1:])
            return asked(partial(ask_user, word, self.functions[word]), arguments)
        if word not in BUILT_IN:
            return self._test(form, word)
        kinds, answer = BUILT_IN[word]
        nodes = parts(form, len(kinds), len(kinds), f"{len(kinds)} arguments for {word}")
        inner = nodes[0] if nodes else None
        if word in KNOWN and isinstance(inner, Form) and head(inner) in {"and", "or"}:
            every = (form.with_items((form.items[0], item)) for item in inner.items[1:])
            each = [self._asked(one, word) for one in every]
            return all_of(each) if head(inner) == "and" else any_of(each)
        return asked(answer, tuple(map(self._argument, nodes, kinds)))

    def _test(self, form: Form, word: str) -> Condition:
        test = self.words.functions.get(word)
        if test is None or isinstance(test, Generator):
            known = (*BUILT_IN, *self.functions)
            fail(first(form), "a registered meta-predicate or test", known)
        arguments = tuple(self.argument(item, Kind.TERM) for item in form.items[1:])
        return asked(partial(ask_test, word, test), arguments)

    def _argument(self, node: Node, kind: Kind) -> Pattern | TypeSpec:
        if kind is Kind.TYPE:
            return parse_type_spec(node, self.words.types)
        return self.argument(node, kind)

    def argument(self, node: Node, kind: Kind) -> Pattern:
        """Return the pattern that ``node`` writes, checked for what it stands for."""
        if is_variable(node):
            return Variable(as_word(node, "a variable").text)
        match kind:
            case Kind.GOAL | Kind.FACT:
                return self._literal(node)
            case Kind.OPERATOR:
                return self._operator(node)
            case Kind.INSTANCE:
                return self._instance(node)
            case Kind.BINDINGS:
                return self._bindings(as_form(node, "bindings ((<v> . value) ...)"))
            case Kind.NODE:
                value = _term(as_word(node, "a variable or the number of a node"))
                return value if isinstance(value, int) else fail(node, "the number of a node")
        return self._any(node)

    def _literal(self, node: Node) -> ListPattern:
        form = as_form(node, "a literal in parentheses, or a variable")
        if head(form) in NEGATIONS:
            (inner,) = parts(form, 1, 1, "one literal")
            made = self._literal(inner)
            return ListPattern(made.name, made.terms, not made.positive)
        name = as_word(first(form), "the name of a predicate").text
        terms = tuple(_term(as_word(item, "a term")) for item in form.items[1:])
        self.words.check_known(form, name, len(terms))
        return ListPattern(name, terms)

    def _operator(self, node: Node) -> Pattern:
        if isinstance(node, Word):
            return self._named(node).name
        return OneOf(tuple(self._named(item).name for item in node.items))

    def _named(self, node: Node) -> Operator:
        word = as_word(node, "an operator")
        if word.text not in self.operators:
            fail(word, "an operator", self.operators)
        return self.operators[word.text]

    def _instance(self, node: Node) -> Pattern:
        if isinstance(node, Word):
            return self._named(node).name
        operator = self._named(first(node))
        terms = tuple(_term(as_word(item, "a term")) for item in node.items[1:])
        if len(terms) != len(operator.params):
            wanted = " ".join(operator.params)
            fail(node, f"{len(operator.params)} parameters of {operator.name} ({wanted})")
        return ListPattern(operator.name, terms)

    def _bindings(self, form: Form) -> Pattern:
        inner = form.items[0] if form.items else None
        if isinstance(inner, Form) and inner.items and isinstance(inner.items[0], Form):
            each = (as_form(item, "bindings ((<v> . value) ...)") for item in form.items)
            return OneOf(tuple(self._bindings(item) for item in each))
        return BindingsPattern(tuple(self._pair(item) for item in form.items))

    def _pair(self, node: Node) -> tuple[str, Term]:
        words = [as_word(item, "a term") for item in as_form(node, "(<v> . value)").items]
        if len(words) != 3 or words[1].text != "." or not is_variable(words[0]):
            fail(node, "(<v> . value)")
        known = {spec.name for o in self.operators.values() for spec in o.all_variables()}
        if words[0].text not in known:
            fail(words[0], "a variable of an operator", known)
        return words[0].text, _term(words[2])

    def _any(self, node: Node) -> Pattern:
        """Return what a user's meta-predicate is given, whatever it means there."""
        if isinstance(node, Word):
            return _term(node)
        if head(node) in NEGATIONS and len(node.items) == 2:
            made = self._any(node.items[1])
            if isinstance(made, ListPattern):
                return ListPattern(made.name, made.terms, not made.positive)
        words = [item for item in node.items if isinstance(item, Word)]
        if words and len(words) == len(node.items) and not is_variable(words[0]):
            return ListPattern(head(node), tuple(map(_term, words[1:])))
        if node.items and all(_is_pair(item) for item in node.items):
            return BindingsPattern(tuple(self._pair(item) for item in node.items))
        return OneOf(tuple(self._any(item) for item in node.items))


def _is_pair(node: Node) -> bool:
    return isinstance(node, Form) and len(node.items) == 3 and str(node.items[1]) == "."


def _term(word: Word) -> Term:
    if is_variable(word):
        return Variable(word.text)
    value = number(word.text)
    return word.text if value is None else value
