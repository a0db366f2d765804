"""Parsing of control rules."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from rogue.prodigy._domain import Operator
from rogue.prodigy._events import Choice
from rogue.prodigy._forms import as_form, as_word, fail, head, is_variable, number, parts
from rogue.prodigy._meta_predicates import BUILT_IN, Answer, MetaPredicate, Question, ask_user
from rogue.prodigy._patterns import (
    BindingsPattern,
    ListPattern,
    Pattern,
    RuleBindings,
    RuleValue,
    unify,
)
from rogue.prodigy._reader import Form, Node, Word
from rogue.prodigy._rules import Action, Candidate, DecideRule, PreferRule, Rule, RuleSet
from rogue.prodigy._terms import Value, Variable
from rogue.prodigy._view import SearchView

CHOICES = {
    "goal": Choice.GOAL,
    "goals": Choice.GOAL,
    "operator": Choice.OPERATOR,
    "operators": Choice.OPERATOR,
    "bindings": Choice.BINDINGS,
    "applied-op": Choice.APPLIED_OP,
}
ACTIONS = ("select", "reject", "prefer", "sub-goal", "apply")
NEGATIONS = {"~", "not"}

Condition = Callable[[SearchView, tuple[RuleValue, ...], RuleBindings], Iterator[RuleBindings]]


@dataclass(frozen=True, slots=True)
class _Parser:
    operators: tuple[Operator, ...]
    functions: Mapping[str, MetaPredicate]

    def rule(self, form: Form) -> Rule | PreferRule | DecideRule:
        expected = "a name, (if ...) and (then ...)"
        title, test, then = parts(form, 3, 3, expected)
        name = as_word(title, "the name of the rule").text
        test, then = as_form(test, "(if ...)"), as_form(then, "(then ...)")
        if head(test) != "if" or head(then) != "then":
            fail(test if head(test) != "if" else then, expected)
        (condition,) = parts(test, 1, 1, "one expression after if")
        return self._then(name, then, self._condition(condition))

    def _then(self, name: str, form: Form, condition: Condition) -> Rule | PreferRule | DecideRule:
        words = parts(form, 1, 4, "an action such as select goal (p <x>)")
        action = as_word(words[0], "an action")
        if action.text not in ACTIONS:
            fail(action, "one of " + ", ".join(ACTIONS), ACTIONS)
        if action.text in {"sub-goal", "apply"}:
            return DecideRule(name, Action(action.text), _decides(condition))
        expected = f"{action.text}, a choice, and " + ("two" if action.text == "prefer" else "one")
        what = as_word(parts(form, 3, 4, expected)[1], "a choice")
        if what.text not in CHOICES:
            fail(what, "one of " + ", ".join(CHOICES), CHOICES)
        choice = CHOICES[what.text]
        patterns = [self._candidate(node, choice) for node in words[2:]]
        if len(patterns) != (2 if action.text == "prefer" else 1):
            fail(form, expected)
        if action.text == "prefer":
            return PreferRule(name, choice, _prefers(condition, patterns[0], patterns[1]))
        return Rule(name, choice, Action(action.text), _speaks_of(condition, patterns[0]))

    def _candidate(self, node: Node, choice: Choice) -> Pattern:
        if choice is Choice.OPERATOR and isinstance(node, Word) and not is_variable(node):
            names = [o.name for o in self.operators]
            return node.text if node.text in names else fail(node, "an operator", names)
        return pattern(node)

    def _condition(self, node: Node) -> Condition:
        form = as_form(node, "a meta-predicate in parentheses")
        word = head(form)
        if word == "and":
            return _all([self._condition(item) for item in form.items[1:]])
        if word == "or":
            return _any([self._condition(item) for item in form.items[1:]])
        if word in NEGATIONS:
            (inner,) = parts(form, 1, 1, f"one expression after {word}")
            return _none(self._condition(inner))
        arguments = tuple(pattern(item) for item in form.items[1:])
        if word in self.functions:
            function = self.functions[word]
            return _asked(lambda question: ask_user(word, function, question), arguments)
        if word not in BUILT_IN:
            known = (*BUILT_IN, *self.functions)
            fail(form.items[0] if form.items else form, "a registered meta-predicate", known)
        least, meaning = BUILT_IN[word]
        if len(arguments) < least:
            fail(form, f"{least} arguments for {word}")
        return _asked(meaning, arguments)


def parse_rules(
    forms: list[Form],
    operators: tuple[Operator, ...],
    functions: Mapping[str, MetaPredicate],
) -> RuleSet:
    """Return control rules in order of definition.

    Raises:
        PdlError: For a rule that is not well formed or names an unknown meta-predicate.
    """
    parser = _Parser(operators, {name.lower(): f for name, f in functions.items()})
    return RuleSet(tuple(parser.rule(form) for form in forms))


def pattern(node: Node) -> Pattern:
    """Return a variable, a constant, a literal's pattern or ``((<v> . x) ...)``."""
    if isinstance(node, Word):
        return _term(node)
    if head(node) in NEGATIONS:
        (inner,) = parts(node, 1, 1, "one literal")
        made = pattern(inner)
        if not isinstance(made, ListPattern):
            fail(inner, "a literal in parentheses")
        return ListPattern(made.name, made.terms, not made.positive)
    if node.items and isinstance(node.items[0], Form):
        return BindingsPattern(tuple(_pair(item) for item in node.items))
    if not head(node):
        fail(node, "a literal in parentheses")
    terms = tuple(_term(as_word(item, "a term")) for item in node.items[1:])
    return ListPattern(head(node), terms)


def _pair(node: Node) -> tuple[str, Variable | Value]:
    words = [as_word(item, "a term") for item in as_form(node, "(<v> . value)").items]
    if len(words) != 3 or words[1].text != "." or not is_variable(words[0]):
        fail(node, "(<v> . value)")
    return words[0].text, _term(words[2])


def _term(word: Word) -> Variable | Value:
    if is_variable(word):
        return Variable(word.text)
    value = number(word.text)
    return word.text if value is None else value


def _asked(meaning: Callable[[Question], Answer], arguments: tuple[Pattern, ...]) -> Condition:
    def condition(
        view: SearchView, candidates: tuple[RuleValue, ...], bindings: RuleBindings
    ) -> Iterator[RuleBindings]:
        yield from meaning(Question(view, candidates, arguments, bindings))

    return condition


def _all(conditions: list[Condition]) -> Condition:
    def condition(
        view: SearchView, candidates: tuple[RuleValue, ...], bindings: RuleBindings
    ) -> Iterator[RuleBindings]:
        found: Iterable[RuleBindings] = [bindings]
        for part in conditions:
            found = [after for before in found for after in part(view, candidates, before)]
        yield from found

    return condition


def _any(conditions: list[Condition]) -> Condition:
    def condition(
        view: SearchView, candidates: tuple[RuleValue, ...], bindings: RuleBindings
    ) -> Iterator[RuleBindings]:
        for part in conditions:
            yield from part(view, candidates, bindings)

    return condition


def _none(inner: Condition) -> Condition:
    def condition(
        view: SearchView, candidates: tuple[RuleValue, ...], bindings: RuleBindings
    ) -> Iterator[RuleBindings]:
        if not any(True for _ in inner(view, candidates, bindings)):
            yield bindings

    return condition


def _decides(condition: Condition) -> Callable[[SearchView], bool]:
    return lambda view: any(True for _ in condition(view, (), {}))


def _speaks_of(
    condition: Condition, wanted: Pattern
) -> Callable[[SearchView, Candidate, tuple[Candidate, ...]], bool]:
    def test(view: SearchView, candidate: Candidate, among: tuple[Candidate, ...]) -> bool:
        # The candidate is bound first: then the condition has less to enumerate.
        start = unify(wanted, candidate, {})
        return start is not None and any(True for _ in condition(view, among, start))

    return test


def _prefers(
    condition: Condition, better: Pattern, worse: Pattern
) -> Callable[[SearchView, Candidate, Candidate], bool]:
    def test(view: SearchView, one: Candidate, other: Candidate) -> bool:
        start = unify(better, one, {})
        both = unify(worse, other, start) if start is not None else None
        return both is not None and any(True for _ in condition(view, (one, other), both))

    return test
