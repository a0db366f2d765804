"""Parsing of control rules."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rogue.prodigy._domain import Operator
from rogue.prodigy._forms import fail
from rogue.prodigy._parse_expression import Vocabulary
from rogue.prodigy._reader import Form
from rogue.prodigy._rules import RuleSet

MetaPredicate = Callable[..., object]


def parse_rules(
    forms: list[Form],
    words: Vocabulary,
    operators: tuple[Operator, ...],
    functions: Mapping[str, MetaPredicate],
) -> RuleSet:
    """Return the control rules."""
    for form in forms:
        fail(form, "no control rule")
    return RuleSet()
