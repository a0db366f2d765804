"""Parsing of operators and inference rules."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rogue.prodigy._domain import Effect, InferenceMode, InferenceRule, Operator
from rogue.prodigy._expressions import TRUE, And, Expression, VariableSpec, atoms, required
from rogue.prodigy._forms import as_form, as_list, as_word, fail, first, head, is_variable, parts
from rogue.prodigy._parse_expression import Scope, Vocabulary
from rogue.prodigy._reader import Form, Node, Word
from rogue.prodigy._terms import Atom

OPERATOR_SECTIONS = ("params", "preconds", "effects")
RULE_SECTIONS = ("mode", *OPERATOR_SECTIONS)
MODES = ("eager", "lazy")
EFFECTS = ("add", "del", "if", "forall")
FOR_ABSTRACTION = ("primary-effects", "axioms")
"""Read and left aside: they guide a search by levels of abstraction only."""


def parse_operators(
    forms: list[Form], words: Vocabulary
) -> tuple[tuple[Operator, ...], tuple[InferenceRule, ...]]:
    """Return the operators and the inference rules of a domain, each in order of definition.

    Raises:
        PdlError: At the first thing that is wrong.
    """
    operators: dict[str, Operator] = {}
    rules: dict[str, InferenceRule] = {}
    for form in forms:
        kind = head(form)
        if kind in {"operator", "inference-rule"}:
            name = as_word(form.items[1] if form.items[1:] else form, f"the name of the {kind}")
            if name.text in operators or name.text in rules:
                fail(name, "a name that no operator and no inference rule has yet")
            if kind == "operator":
                operators[name.text] = _operator(form, name, OPERATOR_SECTIONS, words)
            else:
                rules[name.text] = _inference_rule(form, name, words)
    return tuple(operators.values()), _with_static(tuple(operators.values()), rules)


def _operator(form: Form, name: Word, allowed: tuple[str, ...], words: Vocabulary) -> Operator:
    sections = _sections(form, allowed)
    for needed in ("preconds", "effects"):
        if needed not in sections:
            fail(form, f"({needed} ...) in {head(form)} {name.text}")
    variables, precondition = _preconds(sections["preconds"], words)
    scope = frozenset(v.name for v in variables)
    locals_, effects = _effects(sections["effects"], words, scope)
    params = tuple(spec.name for spec in variables)
    if "params" in sections:
        params = _params(sections["params"], {spec.name for spec in (*variables, *locals_)})
    for spec in variables:
        _check_bindable(sections["preconds"], spec, precondition, effects, words)
    return Operator(name.text, params, variables, precondition, effects)


def _check_bindable(
    section: Form,
    spec: VariableSpec,
    precondition: Expression,
    effects: tuple[Effect, ...],
    words: Vocabulary,
) -> None:
    """Fail for a variable of infinite type for which nothing can ever give a value."""
    infinite = words.types.infinite_of(spec.types)
    if not infinite or any(words.generates(call) for call in spec.calls):
        return
    facts = {name for r in required(precondition) if r.positive for name in r.variables}
    if spec.name not in facts.union(*(effect.atom.variables() for effect in effects)):
        expected = f"a generator, an effect or a precondition that gives {spec.name} its value"
        fail(section, f"{expected}, since {infinite[0]} is infinite")


def _sections(form: Form, allowed: tuple[str, ...]) -> dict[str, Form]:
    expected = ", ".join(f"({word} ...)" for word in allowed)
    sections: dict[str, Form] = {}
    for node in form.items[2:]:
        section = as_form(node, expected)
        if head(section) not in (*allowed, *FOR_ABSTRACTION):
            fail(first(section), expected, allowed)
        if head(section) in sections:
            fail(section, f"({head(section)} ...) only once")
        sections[head(section)] = section
    return sections


def _inference_rule(form: Form, name: Word, words: Vocabulary) -> InferenceRule:
    made = _operator(form, name, RULE_SECTIONS, words)
    section = _sections(form, RULE_SECTIONS).get("mode")
    mode = InferenceMode.LAZY
    if section is not None:
        (word,) = parts(section, 1, 1, "(mode eager) or (mode lazy)")
        if as_word(word, "eager or lazy").text not in MODES:
            fail(word, "eager or lazy", MODES)
        mode = InferenceMode(as_word(word, "eager or lazy").text)
    return InferenceRule(
        made.name, made.params, made.variables, made.precondition, made.effects, mode
    )


def _with_static(
    operators: tuple[Operator, ...], rules: dict[str, InferenceRule]
) -> tuple[InferenceRule, ...]:
    """Return the rules, those static whose conditions neither operators nor other rules change."""
    static = {name for name, rule in rules.items() if rule.mode is InferenceMode.EAGER}
    while True:
        changing = [*operators, *(rule for name, rule in rules.items() if name not in static)]
        changed = {effect.atom.predicate for o in changing for effect in o.effects}
        still = {name for name in static if not _asks_for(rules[name]) & changed}
        if still == static:
            break
        static = still
    return tuple(
        replace(rule, mode=InferenceMode.STATIC) if name in static else rule
        for name, rule in rules.items()
    )


def _asks_for(rule: InferenceRule) -> set[str]:
    conditions = (rule.precondition, *(effect.condition for effect in rule.effects))
    specs = (*rule.variables, *(v for effect in rule.effects for v in effect.variables))
    generated = {call.pattern.predicate for v in specs for call in v.calls if call.pattern}
    return generated | {atom.predicate for c in conditions for atom in atoms(c)}


def _params(section: Form, known: set[str]) -> tuple[str, ...]:
    for node in section.items[1:]:
        if not is_variable(node) or as_word(node, "a variable").text not in known:
            fail(node, "a variable declared in preconds or effects", sorted(known))
    return tuple(as_word(node, "a variable").text for node in section.items[1:])


def _preconds(section: Form, words: Vocabulary) -> tuple[tuple[VariableSpec, ...], Expression]:
    nodes = parts(section, 1, 2, "variables and one expression")
    variables = words.variables(nodes[0])
    scope = frozenset(v.name for v in variables)
    return variables, words.expression(nodes[1], scope) if len(nodes) > 1 else TRUE


def _effects(
    section: Form, words: Vocabulary, scope: Scope
) -> tuple[tuple[VariableSpec, ...], tuple[Effect, ...]]:
    declared, changes = parts(section, 2, 2, "variables and a list of effects")
    # A variable of the preconditions that is declared again is the same one.
    locals_ = tuple(v for v in words.variables(declared, scope) if v.name not in scope)
    effects = list(_changes(changes, words, scope, locals_, TRUE))
    return locals_, tuple(sorted(effects, key=lambda effect: effect.adds))


def _changes(
    node: Node,
    words: Vocabulary,
    scope: Scope,
    locals_: tuple[VariableSpec, ...],
    condition: Expression,
) -> Iterator[Effect]:
    items = as_list(node, "a list of effects")
    is_single = isinstance(node, Form) and head(node) in EFFECTS
    for item in (node,) if is_single else items:
        form = as_form(item, "(add ...), (del ...), (if ...) or (forall ...)")
        yield from _change(form, words, scope, locals_, condition)


def _change(
    form: Form,
    words: Vocabulary,
    scope: Scope,
    locals_: tuple[VariableSpec, ...],
    condition: Expression,
) -> Iterator[Effect]:
    inner = scope | {v.name for v in locals_}
    match head(form):
        case "add" | "del" as kind:
            (atom,) = (words.atom(n, inner) for n in parts(form, 1, 1, "one literal"))
            yield _effect(atom, locals_, condition, adds=kind == "add")
        case "if":
            test, then = parts(form, 2, 2, "a condition and a list of effects")
            both = _both(condition, words.expression(test, inner))
            yield from _changes(then, words, scope, locals_, both)
        case "forall":
            nodes = parts(form, 2, 3, "variables, a condition and a list of effects")
            wider = (*locals_, *words.quantified(nodes[0], inner))
            if len(nodes) == 3:
                names = scope | {v.name for v in wider}
                condition = _both(condition, words.expression(nodes[1], names))
            yield from _changes(nodes[-1], words, scope, wider, condition)
        case _:
            fail(first(form), "add, del, if or forall", EFFECTS)


def _both(one: Expression, other: Expression) -> Expression:
    return other if one == TRUE else And((one, other))


def _effect(
    atom: Atom, locals_: tuple[VariableSpec, ...], condition: Expression, *, adds: bool
) -> Effect:
    used = set(atom.variables())
    used.update(name for a in atoms(condition) for name in a.variables())
    while True:
        kept = tuple(v for v in locals_ if v.name in used)
        needed = {name for v in kept for call in v.calls for name in call.variables()}
        if needed <= used:
            return Effect(atom, adds, kept, condition)
        used |= needed
