"""Reading of s-expressions with the place of every word."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from rogue.prodigy._errors import PdlError, Position

MAX_NESTING = 100
_TOKEN = re.compile(
    r"""(?P<space>\s+|;[^\n]*|\#\|.*?\|\#)
      | (?P<open>\()
      | (?P<close>\))
      | (?P<quote>\#'|')
      | (?P<string>"[^"]*")
      | (?P<word>[^\s()'";]+)""",
    re.VERBOSE | re.DOTALL,
)
_SHOWN = 30


@dataclass(frozen=True, slots=True)
class Word:
    """A symbol, number or string; in lower case unless it is a string."""

    text: str
    position: Position

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, slots=True)
class Form:
    """A list in parentheses."""

    items: tuple[Node, ...]
    position: Position

    def __str__(self) -> str:
        words = [i.text if isinstance(i, Word) else "(...)" for i in self.items[:4]]
        more = " ..." if len(self.items) > len(words) else ""
        return "(" + " ".join(words) + more + ")"


Node = Word | Form


def read(text: str, file: str) -> tuple[Node, ...]:
    """Return the top-level nodes of ``text``; ``file`` names it in errors.

    Raises:
        PdlError: For unbalanced parentheses, an open string or comment, or nesting too deep.
    """
    stack: list[tuple[list[Node], Position]] = []
    items: list[Node] = []
    for kind, token, position in _tokens(text, file):
        if kind == "open":
            if len(stack) == MAX_NESTING:
                raise PdlError(position, "'('", f"at most {MAX_NESTING} levels of parentheses")
            stack.append((items, position))
            items = []
        elif kind == "close":
            if not stack:
                raise PdlError(position, "')'", "'(' or the end of the text")
            outer, opened = stack.pop()
            outer.append(Form(tuple(items), opened))
            items = outer
        else:
            items.append(Word(token if kind == "string" else token.lower(), position))
    if stack:
        raise PdlError(_end(text, file), "the end of the text", f"')' for '(' at {stack[-1][1]}")
    return tuple(items)


def _tokens(text: str, file: str) -> Iterator[tuple[str, str, Position]]:
    at, line, start = 0, 1, 0
    while at < len(text):
        found = _TOKEN.match(text, at)
        position = Position(file, line, at - start + 1)
        if found is None or (found[0].startswith("#|") and found.lastgroup == "word"):
            expected = "'\"' that ends the string" if text[at] == '"' else "'|#' ending the comment"
            raise PdlError(position, text[at : at + _SHOWN].split("\n", maxsplit=1)[0], expected)
        kind = found.lastgroup or ""
        if kind not in {"space", "quote"}:
            yield kind, found[0], position
        newlines = found[0].count("\n")
        if newlines:
            line += newlines
            start = at + found[0].rindex("\n") + 1
        at = found.end()


def _end(text: str, file: str) -> Position:
    return Position(file, text.count("\n") + 1, len(text) - (text.rfind("\n") + 1) + 1)
