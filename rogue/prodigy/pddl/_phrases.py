"""What a PDDL text consists of, before it means anything."""

from __future__ import annotations

import string
from dataclasses import dataclass, replace
from typing import Literal

from rogue.prodigy._errors import PdlError, Position
from rogue.prodigy._reader import MAX_NESTING, Word

_LOWER = str.maketrans(string.ascii_uppercase, string.ascii_lowercase)
_SHOWN = 30


@dataclass(frozen=True, slots=True)
class Phrase:
    """What one rule of the grammar has matched, without its parentheses.

    Attributes:
        rule: Name of the rule.
        parts: Words and phrases in the order written.
        position: Of the first character.
    """

    rule: str
    parts: tuple[Part, ...]
    position: Position

    def __str__(self) -> str:
        words = " ".join(str(part) for part in self.parts)
        return f"({words[:_SHOWN]} ...)" if len(words) > _SHOWN else f"({words})"

    def word(self, at: int) -> Word:
        """Return the word at ``at``, which the grammar has seen to be one."""
        word = self.parts[at]
        assert isinstance(word, Word)
        return word

    def phrases(self, rule: str = "") -> tuple[Phrase, ...]:
        """Return the parts that are phrases, of ``rule`` if it is given."""
        found = (part for part in self.parts if isinstance(part, Phrase))
        return tuple(part for part in found if rule in {"", part.rule})

    def section(self, rule: str) -> Phrase | None:
        """Return the part that is a phrase of ``rule``, None if there is none."""
        return next(iter(self.phrases(rule)), None)


Part = Word | Phrase


def parse_phrase(text: str, file: str, start: Literal["domain", "problem"]) -> Phrase:
    """Read ``text`` as a domain or a problem; ``file`` names it in errors.

    Raises:
        PdlError: At the first place that is no PDDL, or no requirement that is known.
    """
    from rogue.prodigy.pddl._grammar import read_phrase  # noqa: PLC0415 - only PDDL pays for lark

    lowered = text.translate(_LOWER)
    _check_nesting(lowered, file)
    return read_phrase(lowered, file, start)


def _check_nesting(text: str, file: str) -> None:
    depth = 0
    for at, line in enumerate(text.split("\n"), start=1):
        code = line.partition(";")[0]
        if depth + code.count("(") > MAX_NESTING:
            _check_line(code, depth, Position(file, at, 1))
        depth += code.count("(") - code.count(")")


def _check_line(code: str, depth: int, start: Position) -> None:
    for column, character in enumerate(code, start=1):
        depth += (character == "(") - (character == ")")
        if depth > MAX_NESTING:
            expected = f"at most {MAX_NESTING} levels of parentheses"
            raise PdlError(replace(start, column=column), "'('", expected)
