"""Reading of s-expressions; every word and list knows its place."""

from __future__ import annotations

import re
import sys
from bisect import bisect_right
from collections.abc import Iterator
from functools import cached_property

from rogue.prodigy._errors import PdlError, Position

MAX_NESTING = 100
"""Levels of parentheses; what reads and evaluates expressions recurses by level."""

_TOKEN = re.compile(
    r"""\s*(?:
        (?P<open>\()
      | (?P<close>\))
      | (?P<comment>;[^\n]*)
      | (?P<block>\#\|)
      | (?P<quote>\#'|'|`|,@|,)
      | (?P<string>"(?:[^"\\]|\\.)*+")
      | (?P<open_string>")
      | (?P<character>\#\\(?:\w+|.))
      | (?P<word>[^\s()'";]+)
    )""",
    re.VERBOSE | re.DOTALL,
)
_COMMENT_EDGE = re.compile(r"#\||\|#")
_SHOWN = 30


class Source:
    """A text and its name; finds the place of an offset."""

    def __init__(self, text: str, file: str) -> None:
        self.text = text
        self.file = file

    @cached_property
    def _line_starts(self) -> list[int]:
        return [0, *(found.end() for found in re.finditer("\n", self.text))]

    def position(self, offset: int) -> Position:
        """Return line and column, both from 1."""
        line = bisect_right(self._line_starts, offset)
        return Position(self.file, line, offset - self._line_starts[line - 1] + 1)


class Word:
    """A symbol, number or string; in lower case unless it is a string.

    ``place`` is where it stands, or the text in which it stands at ``offset``.
    """

    __slots__ = ("_offset", "_place", "text")

    def __init__(self, text: str, place: Position | Source, offset: int = 0) -> None:
        self.text = text
        self._place = place
        self._offset = offset

    @property
    def position(self) -> Position:
        """Where it stands."""
        place = self._place
        return place if isinstance(place, Position) else place.position(self._offset)

    def __str__(self) -> str:
        return self.text


class Form:
    """A list in parentheses."""

    __slots__ = ("_offset", "_source", "items")

    def __init__(self, items: tuple[Node, ...], source: Source, offset: int) -> None:
        self.items = items
        self._source = source
        self._offset = offset

    @property
    def position(self) -> Position:
        """Where its parenthesis opens."""
        return self._source.position(self._offset)

    def with_items(self, items: tuple[Node, ...]) -> Form:
        """Return a list at the same place."""
        return Form(items, self._source, self._offset)

    def __str__(self) -> str:
        words = [i.text if isinstance(i, Word) else "(...)" for i in self.items[:4]]
        more = " ..." if len(self.items) > len(words) else ""
        return "(" + " ".join(words) + more + ")"


Node = Word | Form


def read(text: str, file: str) -> tuple[Node, ...]:
    """Return the top-level nodes of ``text``; ``file`` names it in errors.

    Quotes (``'x``, ``#'x``) are dropped, comments (``;`` and nested ``#| |#``) skipped.

    Raises:
        PdlError: For unbalanced parentheses, an open string or comment, or nesting too deep.
    """
    source = Source(text, file)
    stack: list[tuple[list[Node], int]] = []
    items: list[Node] = []
    for kind, token, offset in _tokens(source):
        if kind == "open":
            if len(stack) == MAX_NESTING:
                expected = f"at most {MAX_NESTING} levels of parentheses"
                raise PdlError(source.position(offset), "'('", expected)
            stack.append((items, offset))
            items = []
        elif kind == "close":
            if not stack:
                raise PdlError(source.position(offset), "')'", "'(' or the end of the text")
            outer, opened = stack.pop()
            outer.append(Form(tuple(items), source, opened))
            items = outer
        else:
            items.append(Word(sys.intern(_as_named(kind, token)), source, offset))
    if stack:
        raise _unclosed(source, [opened for _, opened in stack])
    return tuple(items)


def _as_named(kind: str, token: str) -> str:
    return token.lower() if kind == "word" else token


def _tokens(source: Source) -> Iterator[tuple[str, str, int]]:
    text, at, match = source.text, 0, _TOKEN.match
    while found := match(text, at):
        kind = found.lastgroup or ""
        start, at = found.span(kind)
        if kind == "open_string":
            raise PdlError(source.position(start), _line_at(text, start), "'\"' ending the string")
        if kind == "block":
            at = _end_of_comment(source, start)
        elif kind not in {"comment", "quote"}:
            yield kind, found[kind], start


def _end_of_comment(source: Source, start: int) -> int:
    depth = 0
    for edge in _COMMENT_EDGE.finditer(source.text, start):
        depth += 1 if edge[0] == "#|" else -1
        if depth == 0:
            return edge.end()
    raise PdlError(source.position(start), _line_at(source.text, start), "'|#' ending the comment")


def _line_at(text: str, start: int) -> str:
    return text[start : start + _SHOWN].split("\n", maxsplit=1)[0]


def _unclosed(source: Source, opened: list[int]) -> PdlError:
    """Return the error for parentheses that stay open; it names the first and the last."""
    last = source.position(opened[-1])
    expected = f"')' for '(' at {last}"
    if len(opened) > 1:
        expected += f", and {len(opened) - 1} more up to '(' at {source.position(opened[0])}"
    return PdlError(source.position(len(source.text)), "the end of the text", expected)
