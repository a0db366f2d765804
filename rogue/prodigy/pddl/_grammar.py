"""The syntax of PDDL, read by the library ``pddl``: the only file that knows it.

The library is that of the AI-Planning group: kept, MIT, 0.3 MB with lark as its only weight
(unified-planning brings scipy and takes a second to read a file; Loki is GPL). Of it we take the
grammar, and lark runs it. Its own classes are not used, because they keep actions, objects and
facts in sets: PRODIGY's choices follow the order in which things are written, and errors need
line and column.
"""

from __future__ import annotations

import functools
import re
import threading
from collections.abc import Iterable
from typing import Any

from lark import Lark, Token, Transformer, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken
from pddl.parser import GRAMMAR_FILE  # type: ignore[import-untyped]

from rogue.prodigy._errors import PdlError, Position
from rogue.prodigy._reader import Word
from rogue.prodigy.pddl._phrases import Part, Phrase

_SHOWN = 30
_BRACKETS = {"LPAR", "RPAR"}
_KINDS = {
    "NAME": "a name",
    "NUMBER": "a number",
    "QMARK": "a variable",
    "LPAR": "'('",
    "RPAR": "')'",
    "$END": "the end of the text",
}
"""How terminals are called in errors, where not as they are written."""


def read_phrase(text: str, file: str, start: str) -> Phrase:
    """Read ``text``, in lower case, from the rule ``start`` on.

    Raises:
        PdlError: At the first place that is no PDDL.
    """
    try:
        return _reader().read(text, file, start)
    except UnexpectedInput as error:
        raise _as_pdl_error(error, text, file) from None


class _Reader:
    """The grammar, made once; one text at a time, since what is found is named by its file."""

    def __init__(self) -> None:
        self._phrases = _Phrases()
        self._lock = threading.Lock()
        grammar, starts = GRAMMAR_FILE.read_text(), ["domain", "problem"]
        self._lark = Lark(grammar, parser="lalr", start=starts, transformer=self._phrases)
        self.written = {t.name: t.pattern.value for t in self._lark.terminals} | _KINDS

    def read(self, text: str, file: str, start: str) -> Phrase:
        with self._lock:
            self._phrases.file = file
            found: object = self._lark.parse(text, start=start)
        assert isinstance(found, Phrase)
        return found


@functools.cache
def _reader() -> _Reader:
    return _Reader()


class _Phrases(Transformer[Token, Phrase]):
    """Makes phrases of what lark finds; its helper rules, named with an underscore, stay trees."""

    file = ""

    def __default__(self, data: str, children: list[Any], _meta: object) -> Phrase | Tree[Any]:
        if data.startswith("_"):
            return Tree(data, children)
        known = [child for child in children if child is not None]
        parts = tuple(self._part(c) for c in known if getattr(c, "type", "") not in _BRACKETS)
        position = self._position(known[0]) if known else Position(self.file, 1, 1)
        return Phrase(str(data), parts, position)

    def _part(self, child: Token | Phrase) -> Part:
        return child if isinstance(child, Phrase) else Word(str(child), self._position(child))

    def _position(self, child: Token | Phrase) -> Position:
        if isinstance(child, Phrase):
            return child.position
        return Position(self.file, child.line or 1, child.column or 1)


def _as_pdl_error(error: UnexpectedInput, text: str, file: str) -> PdlError:
    allowed = error.allowed if isinstance(error, UnexpectedCharacters) else _accepted(error)
    written = _reader().written
    expected = sorted({written.get(name, name) for name in allowed})
    is_end = isinstance(error, UnexpectedToken) and error.token.type == "$END"
    line, column = _end(text) if is_end else (error.line, error.column)
    found = _KINDS["$END"] if is_end else _found(text.split("\n")[line - 1][column - 1 :])
    listed = " or ".join(expected) if len(expected) < 3 else "one of " + ", ".join(expected)
    return PdlError(Position(file, line, column), found, listed, expected)


def _accepted(error: UnexpectedInput) -> Iterable[str]:
    assert isinstance(error, UnexpectedToken)
    return error.accepts


def _found(rest: str) -> str:
    word = re.match(r"[^\s()]+", rest[:_SHOWN])
    return word[0] if word and word[0].isprintable() else repr(rest[:1])


def _end(text: str) -> tuple[int, int]:
    return text.count("\n") + 1, len(text) - (text.rfind("\n") + 1) + 1
