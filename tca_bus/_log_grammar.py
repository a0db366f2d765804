"""Lines in the grammar of TCA's log, so that its viewers and log readers take them.

Names are written with the characters that the grammar allows. What has no words in it stands in
lines of four blanks and text, which its readers take for data and skip.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from typing import Any

from tca_bus._errors import ConfigError
from tca_bus._log_statements import (
    Answered,
    ConstraintAdded,
    DemonFired,
    KillAwaited,
    MessagePassed,
    NodeKilled,
    NodeRef,
    PointsOrdered,
    Remark,
    Replied,
    RetryAsked,
    Statement,
    TimePoint,
)

LETTERS = {
    "m": "messages and constraints",
    "s": "answers and kills",
    "t": "the time",
    "d": "ids and data, a line each",
    "i": "no registrations; the history has none",
    "h": "a summary of the time spent in handlers, at the end",
    "r": "the number of each node",
    "p": "the number of its parent",
    "n": "no remarks",
}
"""The letters of central's ``-l`` in TCA that mean something here."""

LINE_LENGTH = 80
"""Where a line of data is cut, as in TCA."""

_NOT_IN_NAME = re.compile(r"[^A-Za-z0-9_*-]")
_NO_NAME = re.compile(r"-|[0-9]+\Z|(and|on|Resource)\Z|\Z")
"""What the grammar would take for a number, a keyword or nothing at all."""


@dataclass(frozen=True, slots=True)
class Letters:
    """What lines to show, and what in them."""

    chosen: frozenset[str]

    @classmethod
    def parse(cls, text: str) -> Letters:
        """Read letters as a user types them.

        Raises:
            ConfigError: One of them means nothing.
        """
        unknown = sorted(set(text) - set(LETTERS))
        if unknown or not text:
            known = ", ".join(f"{letter} ({meaning})" for letter, meaning in LETTERS.items())
            raise ConfigError("--letters", text, f"letters of: {known}")
        return cls(frozenset(text))

    def __contains__(self, letter: str) -> bool:
        return letter in self.chosen


def lines_of(statement: Statement, time: float, letters: Letters) -> Iterator[str]:
    """Write a statement, unless the letters leave it out; ``time`` is seconds since the epoch."""
    if _letter_of(statement) not in letters and not isinstance(statement, Remark):
        return
    if isinstance(statement, Remark):
        if "n" not in letters and "s" in letters:
            yield _remark_line(statement.text)
        return
    line = _Writer(letters).line(statement)
    untimed = isinstance(statement, PointsOrdered | ConstraintAdded | RetryAsked)
    yield line if untimed or "t" not in letters else f"{line}  {_clock(time)}"


def data_line(id: str, data: dict[str, Any]) -> str:
    """The line of data below a message: our id of the node, and what was sent."""
    text = json.dumps(data, ensure_ascii=False) if data else ""
    return _remark_line(f"{id} {text}".rstrip())


def grammar_name(name: str) -> str:
    """A name with the characters of the grammar."""
    name = _NOT_IN_NAME.sub("_", name)
    return f"_{name}" if _NO_NAME.match(name) else name


@dataclass(frozen=True, slots=True)
class _Writer:
    letters: Letters

    def line(self, said: Statement) -> str:
        match said:
            case MessagePassed():
                return self._passed(said)
            case Answered():
                return f"  {said.word:<8} {self._node(said.node)}:{self._by(said)}"
            case Replied():
                way = f"{_place(said.source)} --> {_place(said.destination)}"
                return f"  {'Reply':<8} {self._node(said.node)}: {way}{self._parent(said.parent)}"
            case RetryAsked():
                return f"  {'Retry':<8} {self._node(said.node)}"
            case DemonFired():
                way = f"{_place(said.source)}{self._parent(said.parent)} --> "
                number = self._number(said.number)
                return f"FireDemon{number}: {way}{_place(said.destination)}  ({said.status})"
            case _:
                return self._end_or_constraint(said)

    def _end_or_constraint(self, said: Statement) -> str:
        match said:
            case NodeKilled(by_limit=False):
                return f"Killed {self._node(said.node)}"
            case NodeKilled():
                return f"PENDING LIMIT: Deleted message {self._node(said.node)}"
            case KillAwaited():
                return f"Will kill {self._node(said.node)} {said.situation}"
            case PointsOrdered():
                first, second = self._point(said.first), self._point(said.second)
                return f"   Asserting {first} {said.relation} {second}"
            case ConstraintAdded(previous=None):
                return f"Adding {said.constraint} constraint to {self._node(said.node)}"
            case ConstraintAdded(previous=NodeRef() as previous):
                nodes = f"{self._node(previous)} and {self._node(said.node)}"
                return f"Adding {said.constraint} constraint between {nodes}"
            case _:
                raise TypeError(f"{type(said).__name__} has no line in TCA's log")

    def _passed(self, said: MessagePassed) -> str:
        word = "  ByPass  " if said.word == "ByPass" else f"{said.word:<9}"
        line = f"{word} {self._node(said.node)}:"
        if said.source is not None and said.destination is not None:
            source = f"{_place(said.source)}{self._parent(said.parent)}"
            line += f" {source} --> {_place(said.destination)}"
        return f"{line}  ({said.status})"

    def _by(self, said: Answered) -> str:
        if said.word != "Failure":
            return ""
        return f" {_place(said.module)}{self._parent(said.parent)}"

    def _point(self, point: TimePoint) -> str:
        number = self._number(point.node.number)
        return f"{point.end}({point.interval}({grammar_name(point.node.name)})){number}"

    def _node(self, node: NodeRef) -> str:
        return grammar_name(node.name) + self._number(node.number)

    def _number(self, number: int | None) -> str:
        return f" {{{number}}}" if number is not None and "r" in self.letters else ""

    def _parent(self, number: int | None) -> str:
        return f" {{{number}}}" if number is not None and "p" in self.letters else ""


def _letter_of(statement: Statement) -> str:
    is_status = isinstance(statement, Answered | Replied | RetryAsked | NodeKilled | KillAwaited)
    return "s" if is_status else "m"


def _place(text: str) -> str:
    """A module, ``ON HOLD``, or a resource."""
    head, blank, name = text.partition(" ")
    if blank and head == "Resource":
        return f"Resource {grammar_name(name)}"
    return " ".join(map(grammar_name, text.split(" ")))


def _remark_line(text: str) -> str:
    text = " ".join(text.split())
    room = LINE_LENGTH - 4
    return "    " + (text if len(text) <= room else text[: room - 1] + "…")


def _clock(time: float) -> str:
    when = datetime.fromtimestamp(time).astimezone()
    return f"{when.hour}:{when:%M:%S}.{when.microsecond // 10_000:02d}"
