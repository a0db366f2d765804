"""Small questions to s-expressions, with errors that name the place."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from typing import NoReturn

from rogue.prodigy._errors import PdlError
from rogue.prodigy._reader import Form, Node, Word

_NUMBER = re.compile(r"[+-]?(?:[0-9]{1,300}(?:\.[0-9]*)?|\.[0-9]+)(?:e[+-]?[0-9]{1,4})?")
_RATIO = re.compile(r"([+-]?[0-9]{1,15})/([0-9]{1,15})")


def fail(node: Node, expected: str, known: Iterable[str] = ()) -> NoReturn:
    """Raise PdlError at ``node``."""
    raise PdlError(node.position, str(node), expected, known)


def as_form(node: Node, expected: str) -> Form:
    """Return ``node`` if it is a list, else fail with what was expected."""
    return node if isinstance(node, Form) else fail(node, expected)


def as_word(node: Node, expected: str) -> Word:
    """Return ``node`` if it is a word, else fail with what was expected."""
    return node if isinstance(node, Word) else fail(node, expected)


def as_list(node: Node, expected: str) -> tuple[Node, ...]:
    """Return the nodes of a list, none for Lisp's ``nil``, else fail with what was expected."""
    if isinstance(node, Word) and node.text == "nil":
        return ()
    return as_form(node, expected).items


def head(form: Form) -> str:
    """Return the first word of a list, or "" if it does not begin with one."""
    first = form.items[0] if form.items else None
    return first.text if isinstance(first, Word) else ""


def first(form: Form) -> Node:
    """Return what a list begins with, or the list itself if it is empty."""
    return form.items[0] if form.items else form


def parts(form: Form, least: int, most: int | None, expected: str) -> tuple[Node, ...]:
    """Return what follows the first word; fail unless it is ``least`` to ``most`` nodes."""
    rest = form.items[1:]
    if len(rest) < least or (most is not None and len(rest) > most):
        fail(form, expected)
    return rest


def is_variable(node: Node) -> bool:
    """Say whether ``node`` is a variable in angle brackets."""
    return isinstance(node, Word) and len(node.text) > 2 and node.text[0] + node.text[-1] == "<>"


def number(text: str) -> int | float | None:
    """Return the number that ``text`` writes (``3``, ``-0.5``, ``9/64``), or None."""
    ratio = _RATIO.fullmatch(text)
    if ratio:
        over, under = int(ratio[1]), int(ratio[2])
        if not under:
            return None
        return over // under if over % under == 0 else over / under
    if not _NUMBER.fullmatch(text):
        return None
    if text.lstrip("+-").isdigit():
        return int(text)
    value = float(text)
    return value if math.isfinite(value) else None
