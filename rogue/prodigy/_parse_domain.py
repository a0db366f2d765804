"""Parsing of domains."""

from __future__ import annotations

from collections.abc import Mapping

from rogue.prodigy._domain import Domain
from rogue.prodigy._errors import PdlError, Position
from rogue.prodigy._forms import as_word, fail, first, head
from rogue.prodigy._functions import BUILT_IN, Function
from rogue.prodigy._lisp import without_lisp
from rogue.prodigy._meta_predicates import MetaPredicate
from rogue.prodigy._parse_conditions import ConditionReader
from rogue.prodigy._parse_expression import Vocabulary
from rogue.prodigy._parse_operators import parse_operators
from rogue.prodigy._parse_rules import parse_rules
from rogue.prodigy._parse_types import parse_constants, parse_types
from rogue.prodigy._reader import Form, read

SECTIONS = (
    "create-problem-space",
    "ptype-of",
    "infinite-type",
    "pinstance-of",
    "operator",
    "inference-rule",
    "control-rule",
)


def parse_domain(
    text: str,
    *,
    file: str = "domain",
    functions: Mapping[str, Function] | None = None,
    meta_predicates: Mapping[str, MetaPredicate] | None = None,
) -> Domain:
    """Read a domain from PRODIGY's language.

    Lisp that often stands in such files (``in-package``, ``defun``, ``setf`` ...) is skipped: a
    function that a domain calls is one of ours or one of ``functions``.

    Args:
        text: The domain.
        file: Its name in errors.
        functions: Functions that variables' types may call, by name.
        meta_predicates: Meta-predicates of control rules besides PRODIGY's own, by name.

    Raises:
        PdlError: At the first thing that is wrong, with line and column.
    """
    forms = without_lisp(read(text, file), SECTIONS)
    if not forms:
        raise PdlError(Position(file, 1, 1), "no expression", "a domain with its operators")
    known = {**BUILT_IN, **{name.lower(): f for name, f in (functions or {}).items()}}
    words = Vocabulary(parse_types(forms, known), known)
    constants = parse_constants(forms, words.types)
    operators, inference_rules = parse_operators(forms, words)
    named = {o.name: o for o in (*operators, *inference_rules)}
    users = {name.lower(): f for name, f in (meta_predicates or {}).items()}
    reader = ConditionReader(words, named, users)
    rules = parse_rules([f for f in forms if head(f) == "control-rule"], reader)
    return Domain(
        _name(forms) or file,
        words.types,
        operators,
        words.predicates,
        known,
        constants,
        rules,
        inference_rules,
    )


def _name(forms: list[Form]) -> str:
    spaces = [f for f in forms if head(f) == "create-problem-space"]
    for again in spaces[1:]:
        fail(first(again), "only one create-problem-space")
    return as_word(spaces[0].items[1], "a name").text if spaces and spaces[0].items[1:] else ""
