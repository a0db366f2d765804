"""The true facts of one predicate, found by the values of their arguments."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, KeysView, Mapping

from rogue.prodigy._terms import Value

Row = tuple[Value, ...]
Pattern = tuple[Value | None, ...]
"""Arguments; None where any value will do."""

_FEW = 8
"""Rows that are looked through rather than indexed."""

_Index = dict[Value, dict[Row, None]]


class Relation:
    """An immutable set of rows, in the order in which they came to be.

    An index by an argument is made when it is first asked for, and handed on to the relation
    after a change.
    """

    __slots__ = ("_indexes", "_rows")

    def __init__(self, rows: Iterable[Row] = ()) -> None:
        self._rows: dict[Row, None] = dict.fromkeys(rows)
        self._indexes: dict[int, _Index] = {}

    def rows(self) -> KeysView[Row]:
        """Return all rows."""
        return self._rows.keys()

    def __contains__(self, row: object) -> bool:
        return row in self._rows

    def __len__(self) -> int:
        return len(self._rows)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Relation) and self._rows == other._rows

    __hash__ = None  # type: ignore[assignment]

    def matching(self, pattern: Pattern) -> Collection[Row]:
        """Return the rows that may match: all that do, and few others."""
        if len(self._rows) <= _FEW:
            return self._rows
        if None not in pattern:
            return (pattern,) if pattern in self._rows else ()  # type: ignore[return-value]
        known = ((at, value) for at, value in enumerate(pattern) if value is not None)
        buckets = [self._index(at).get(value, {}) for at, value in known]
        return min(buckets, key=len, default=self._rows)

    def _index(self, at: int) -> Mapping[Value, dict[Row, None]]:
        if at not in self._indexes:
            made: _Index = {}
            for row in self._rows:
                if at < len(row):
                    made.setdefault(row[at], {})[row] = None
            self._indexes[at] = made
        return self._indexes[at]

    def changed(self, gone: Iterable[Row], new: Iterable[Row]) -> Relation:
        """Return the relation without ``gone``, then with ``new``."""
        after = Relation()
        after._rows = dict(self._rows)
        after._indexes = {at: dict(index) for at, index in self._indexes.items()}
        for row in gone:
            if row in after._rows:
                del after._rows[row]
                after._reindex(row, is_there=False)
        for row in new:
            if row not in after._rows:
                after._rows[row] = None
                after._reindex(row, is_there=True)
        return after

    def _reindex(self, row: Row, *, is_there: bool) -> None:
        for at, index in self._indexes.items():
            if at < len(row):
                # The bucket is shared with the relation before the change.
                bucket = dict(index.get(row[at], {}))
                if is_there:
                    bucket[row] = None
                else:
                    bucket.pop(row, None)
                index[row[at]] = bucket

    def difference(self, other: Relation) -> Iterator[Row]:
        """Yield the rows that only one of the two has."""
        yield from (row for row in self._rows if row not in other._rows)
        yield from (row for row in other._rows if row not in self._rows)
