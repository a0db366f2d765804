"""What of a task tree is shown: its rows, with what is folded summed up, and a window on them."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from tca_bus import TaskState, TaskStatus
from tca_bus.cli._forest import WAITING, Forest

MARKS = {
    "inactive": "·",
    "pending": "○",
    "active": "●",
    "handled": "◐",
    "planned": "◑",
    "achieved": "✓",
    "failed": "✗",
    "killed": "⊘",
}

SUSPENDED_MARK = "‖"
"""Instead of the mark of a node that waits and is suspended, or is below one that is."""

LONGEST_RUN = 4
"""Siblings in a row that have all ended, or all wait, of which each has a row of its own."""

SHOWN_OF_RUN = 2
"""Those of a longer run that still have one: the last that ended, the first that wait."""


@dataclass(frozen=True, slots=True)
class Row:
    """One row: a node, or so many nodes folded into one line after ``lead``."""

    lead: str
    id: str | None
    folded: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Line:
    """A row as text; ``state`` is what a colour may show."""

    text: str
    state: TaskState | None = None


def node_text(status: TaskStatus, now: float, folded: str = "") -> str:
    """A node in one line; ``now`` is in seconds since the epoch, ``folded`` what is hidden."""
    seconds = max((status.ended or now) - status.created, 0.0)
    parts = [f"{_mark(status)} {status.name} {status.id}  {_state_words(status)}"]
    parts.append(f"{seconds:.1f} s{folded}")
    if status.handler:
        parts.append(status.handler + (f" (try {status.attempt})" if status.attempt > 1 else ""))
    if status.waiting_for:
        parts.append(f"waits for {status.waiting_for}")
    if status.failure:
        killed = status.state == "killed"
        parts.append(status.failure.text if killed else status.failure.sentence())
    return "  ".join(parts)


def _mark(status: TaskStatus) -> str:
    is_held = status.suspended and status.state in WAITING
    return SUSPENDED_MARK if is_held else MARKS.get(status.state, "?")


def _state_words(status: TaskStatus) -> str:
    words = [status.state.value]
    if status.suspended and not status.is_ended:
        words.append("suspended")
    if status.retries:
        words.append(f"retried {status.retries}x")
    return ", ".join(words)


def counted(counts: Counter[TaskState]) -> str:
    """Say how many nodes are in which state."""
    return ", ".join(f"{counts[state]:,} {state}" for state in TaskState if counts[state])


@dataclass
class TreeView:
    """A window on a forest: scrolled by keys, folded unless told otherwise."""

    forest: Forest
    title: str = ""
    is_folding: bool = True
    note: str = ""
    _top: int = 0
    _anchor: Row | None = None
    _page: int = 1
    _rows: list[Row] = field(default_factory=list)
    _drawn: tuple[int, bool] = (-1, False)
    _counted: int = -1
    _summaries: dict[Row, str] = field(default_factory=dict)

    def press(self, key: str) -> None:
        """Scroll by a key, or fold and unfold with ``f``; other keys do nothing."""
        if key == "f":
            self.is_folding = not self.is_folding
            return
        last = len(self.rows())
        moves = {"up": -1, "down": 1, "page up": -self._page, "page down": self._page}
        jumps = {"home": 0, "end": last}
        self._scroll_to(jumps.get(key, self._top + moves.get(key, 0)))

    def frame(self, now: float, height: int) -> list[Line]:
        """The lines of a screen of ``height`` rows; the first and the last are about the rest."""
        self._page = max(height - 2, 1)
        rows = self.rows()
        self._hold_on(rows)
        shown = rows[self._top : self._top + self._page]
        lines = [self._line(row, now) for row in shown]
        lines += [Line("")] * (self._page - len(lines))
        return [self._head(now), *lines, self._foot(len(shown), len(rows))]

    def rows(self) -> list[Row]:
        """All rows, made anew only when nodes came, went, began or ended."""
        drawn = (self.forest.shape, self.is_folding)
        if drawn != self._drawn:
            self._rows, self._drawn = list(self._walk()), drawn
        return self._rows

    def _walk(self) -> Iterator[Row]:
        stack = [*reversed(list(self._arrange(self.forest.tops(), "", is_top=True)))]
        while stack:
            row, rest = stack.pop()
            yield row
            if row.id is None or row.folded:
                continue
            below = list(self._arrange(self.forest.children(row.id), rest, is_top=False))
            stack += reversed(below)

    def _arrange(self, ids: Sequence[str], lead: str, *, is_top: bool) -> Iterator[tuple[Row, str]]:
        """Siblings as rows, each with what its own children's rows begin with."""
        items = list(self._runs(ids)) if self.is_folding else [(id,) for id in ids]
        for number, item in enumerate(items, 1):
            corner, bar = ("└─ ", "   ") if number == len(items) else ("├─ ", "│  ")
            corner, bar = ("", "") if is_top else (corner, bar)
            if len(item) > 1:
                yield Row(lead + corner, None, item), ""
            else:
                yield Row(lead + corner, item[0], self._hidden(item[0])), lead + bar

    def _hidden(self, id: str) -> tuple[str, ...]:
        """The children that are not shown since all below the node has ended."""
        if not self.is_folding or not self.forest.has_ended(id) or id == self.forest.only:
            return ()
        return tuple(self.forest.children(id))

    def _runs(self, ids: Sequence[str]) -> Iterator[tuple[str, ...]]:
        """Siblings one by one, but for long runs of the same kind, of which most are together."""
        start = 0
        while start < len(ids):
            kind = self._kind(ids[start])
            end = start + 1
            while kind and end < len(ids) and self._kind(ids[end]) == kind:
                end += 1
            yield from _shortened(ids[start:end], keep_last=kind == "ended")
            start = end

    def _kind(self, id: str) -> str | None:
        if self.forest.has_ended(id):
            return "ended"
        waits = self.forest.nodes[id].state in WAITING and not self.forest.children(id)
        return "waiting" if waits else None

    def _line(self, row: Row, now: float) -> Line:
        if row.id is None:
            return Line(f"{row.lead}… {self._summary(row).format('more')}")
        status = self.forest.nodes[row.id]
        folded = f"  [{self._summary(row).format('below')}]" if row.folded else ""
        return Line(row.lead + node_text(status, now, folded), status.state)

    def _summary(self, row: Row) -> str:
        """What is folded into a row, counted anew only when the state of a node changed."""
        if self._counted != self.forest.version:
            self._summaries.clear()
            self._counted = self.forest.version
        if row not in self._summaries:
            many: Counter[TaskState] = Counter()
            for id in row.folded:
                many.update(self.forest.nodes[node].state for node in self.forest.subtree(id))
            self._summaries[row] = f"{many.total():,} {{}}: {counted(many)}"
        return self._summaries[row]

    def _scroll_to(self, top: int) -> None:
        rows = self.rows()
        self._top = max(min(top, len(rows) - self._page), 0)
        self._anchor = rows[self._top] if self._top else None

    def _hold_on(self, rows: Sequence[Row]) -> None:
        """Stay at the row that was on top, wherever it is now."""
        anchor = self._anchor
        if anchor is not None and self._row_at(rows, self._top) != anchor:
            found = (n for n, row in enumerate(rows) if row.id == anchor.id and row.id)
            self._top = next(found, self._top)
        self._scroll_to(self._top)

    def _row_at(self, rows: Sequence[Row], number: int) -> Row | None:
        return rows[number] if number < len(rows) else None

    def _head(self, now: float) -> Line:
        many = self.forest.counts
        clock = time.strftime("%H:%M:%S", time.localtime(now))
        states = counted(many) or "no task is under way"
        nodes = f"{many.total():,} nodes: " if many.total() else ""
        return Line("  ".join(filter(None, [clock, self.title, nodes + states, self.note])))

    def _foot(self, shown: int, rows: int) -> Line:
        fold = "unfold" if self.is_folding else "fold"
        first = self._top + 1 if rows else 0
        place = f"rows {first:,}-{self._top + shown:,} of {rows:,}"
        return Line(f"{place}   ↑ ↓ PgUp PgDn Home End   f {fold}   q quit")


def _shortened(run: Sequence[str], *, keep_last: bool) -> Iterator[tuple[str, ...]]:
    if len(run) <= LONGEST_RUN:
        yield from ((id,) for id in run)
    elif keep_last:
        yield tuple(run[:-SHOWN_OF_RUN])
        yield from ((id,) for id in run[-SHOWN_OF_RUN:])
    else:
        yield from ((id,) for id in run[:SHOWN_OF_RUN])
        yield tuple(run[SHOWN_OF_RUN:])


def tree_lines(statuses: Sequence[TaskStatus], now: float) -> Iterator[str]:
    """Draw nodes as a tree, one line each and none folded; ``now`` as in `node_text`."""
    forest = Forest(most_ended=len(statuses))
    for status in statuses:
        forest.take(status)
    view = TreeView(forest, is_folding=False)
    for row in view.rows():
        yield row.lead + node_text(forest.nodes[row.id or ""], now)
