"""Parsing of control rules."""

from __future__ import annotations

from collections.abc import Iterator

from rogue.prodigy._conditions import Condition
from rogue.prodigy._events import Choice
from rogue.prodigy._forms import as_form, as_word, fail, head, is_variable, parts
from rogue.prodigy._meta_predicates import Kind
from rogue.prodigy._parse_conditions import ConditionReader
from rogue.prodigy._patterns import OneOf, Pattern
from rogue.prodigy._reader import Form, Node, Word
from rogue.prodigy._rules import Action, DecideRule, PreferRule, Rule, RuleSet
from rogue.prodigy._written_rules import written_decision, written_preference, written_rule

CHOICES = {
    "node": (Choice.NODE, Kind.NODE),
    "nodes": (Choice.NODE, Kind.NODE),
    "goal": (Choice.GOAL, Kind.GOAL),
    "goals": (Choice.GOAL, Kind.GOAL),
    "operator": (Choice.OPERATOR, Kind.OPERATOR),
    "operators": (Choice.OPERATOR, Kind.OPERATOR),
    "bindings": (Choice.BINDINGS, Kind.BINDINGS),
    "applied-op": (Choice.APPLIED_OP, Kind.INSTANCE),
}
ACTIONS = ("select", "reject", "prefer", "sub-goal", "apply", "protect")
AnyRule = Rule | PreferRule | DecideRule


def parse_rules(forms: list[Form], reader: ConditionReader) -> RuleSet:
    """Return control rules in order of definition.

    Raises:
        PdlError: For a rule that is not well formed, or names what does not exist.
    """
    rules: dict[str, AnyRule] = {}
    for form in forms:
        rule = _rule(form, reader)
        if rule.name in rules:
            fail(form.items[1], "a name that no control rule has yet")
        rules[rule.name] = rule
    return RuleSet(tuple(rules.values()))


def _rule(form: Form, reader: ConditionReader) -> AnyRule:
    expected = "a name, (if ...) and (then ...)"
    title, test, then = parts(form, 3, 3, expected)
    name = as_word(title, "the name of the rule").text
    test, then = as_form(test, "(if ...)"), as_form(then, "(then ...)")
    if head(test) != "if" or head(then) != "then":
        fail(test if head(test) != "if" else then, expected)
    (condition,) = parts(test, 1, 1, "one expression after if")
    known = frozenset(_variables(condition))
    return _consequence(name, then, reader.condition(condition), known, reader)


def _variables(node: Node) -> Iterator[str]:
    if isinstance(node, Form):
        for item in node.items:
            yield from _variables(item)
    elif is_variable(node):
        yield node.text


def _consequence(
    name: str, form: Form, when: Condition, known: frozenset[str], reader: ConditionReader
) -> AnyRule:
    words = parts(form, 1, None, "an action such as select goal (p <x>)")
    action = as_word(words[0], "an action")
    if action.text not in ACTIONS:
        fail(action, "one of " + ", ".join(ACTIONS), ACTIONS)
    if action.text in {"sub-goal", "apply", "protect"}:
        parts(form, 1, 1, f"nothing after {action.text}")
        return written_decision(name, Action(action.text), when)
    count = "two candidates" if action.text == "prefer" else "candidates"
    what = as_word(parts(form, 3, None, f"{action.text}, a choice, and {count}")[1], "a choice")
    if what.text not in CHOICES:
        fail(what, "one of " + ", ".join(CHOICES), CHOICES)
    choice, kind = CHOICES[what.text]
    wanted = [reader.argument(node, kind) for node in _candidates(words[2:], kind)]
    if action.text != "prefer":
        for node in words[2:]:
            if isinstance(node, Word) and is_variable(node) and node.text not in known:
                fail(node, f"a variable of the if, or it would {action.text} everything", known)
        return written_rule(name, choice, Action(action.text), when, _either(wanted))
    if len(wanted) != 2:
        fail(form, f"two candidates, the better one first, not {len(wanted)}")
    return written_preference(name, choice, when, wanted[0], wanted[1])


def _either(wanted: list[Pattern]) -> Pattern:
    return wanted[0] if len(wanted) == 1 else OneOf(tuple(wanted))


def _candidates(nodes: tuple[Node, ...], kind: Kind) -> Iterator[Node]:
    """Yield the candidates, out of the lists in which several may stand."""
    for node in nodes:
        yield from node.items if isinstance(node, Form) and _is_list(node, kind) else (node,)


def _is_list(form: Form, kind: Kind) -> bool:
    """Say whether ``form`` holds candidates, and is not one itself."""
    inner = form.items[0] if form.items else None
    if kind is Kind.BINDINGS:
        return isinstance(inner, Form) and bool(inner.items) and isinstance(inner.items[0], Form)
    if kind in {Kind.OPERATOR, Kind.NODE}:
        return True
    return isinstance(inner, Form) or (inner is not None and is_variable(inner))
