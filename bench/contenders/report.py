"""The tables of a run, as Markdown."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterable

from contenders.base import p99
from contenders.measure import AT_ONCE, BURST, Plan, Samples, Series

OURS, DIRECT = "tca_bus, router", "tca_bus, direct"
NATS, GRPC, BARE = "NATS", "gRPC asyncio", "bare Zenoh query, router"

WHAT = {
    "query": "Query, one at a time",
    "queries": f"Queries, {AT_ONCE} at a time",
    "inform": "Inform, one way, 500 a second",
    "informs": "Informs, as fast as they go",
    "together": f"Informs, {BURST} sent together with `inform_many`",
    "command": "Command: acknowledged, journaled, handled, its result",
    "commands": f"Commands, {AT_ONCE} at a time",
    "goal": "Goal with ten children",
}

Row = list[str]


def report(samples: Samples, plan: Plan, missing: dict[str, str]) -> str:
    """All tables, what was missing, and which aims were met."""
    parts = [_table(samples, what, size) for what in WHAT for size in plan.sizes]
    parts += [f"Not measured: {title}, {why}." for title, why in missing.items()]
    parts.append(_aims(samples, plan.sizes[0]))
    return "\n\n".join(part for part in parts if part)


def _table(samples: Samples, what: str, size: int) -> str:
    found = {title: seen for (w, title, s), seen in samples.items() if (w, s) == (what, size)}
    if not found:
        return ""
    base = found.get(OURS) or next(iter(found.values()))
    rows = [_row(title, seen, base) for title, seen in found.items()]
    heading = ["", "median µs", "ratio", "p99 µs", "ratio", "per second", "ratio", "lost"]
    return f"**{WHAT[what]}, {_bytes(size)}**\n\n{_markdown(heading, rows)}"


def _row(title: str, seen: Series, base: Series) -> Row:
    row = [title]
    for value in (statistics.median, p99):
        row += _cells(value, seen.times, base.times)
    row += _cells(statistics.median, seen.rates, base.rates)
    row.append(f"{statistics.fmean(seen.lost):.1%}" if seen.lost else "")
    return row


def _cells(value: Callable[[list[float]], float], seen: list[float], base: list[float]) -> Row:
    if not seen or not base or not value(base):
        return ["", ""]
    return [f"{value(seen):,.0f}", f"{value(seen) / value(base):.2f}"]


def _markdown(heading: Row, rows: Iterable[Row]) -> str:
    rows = [heading, *rows]
    used = [any(row[i] for row in rows[1:]) for i in range(len(heading))]
    rows = [[cell for cell, keep in zip(row, used, strict=True) if keep] for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [_line(row, widths) for row in rows]
    rule = "|".join(["-" * (widths[0] + 2), *("-" * (width + 1) + ":" for width in widths[1:])])
    return "\n".join([lines[0], f"|{rule}|", *lines[1:]])


def _line(row: Row, widths: list[int]) -> str:
    first, *others = zip(row, widths, strict=True)
    cells = [first[0].ljust(first[1]), *(cell.rjust(width) for cell, width in others)]
    return "| " + " | ".join(cells) + " |"


def _aims(samples: Samples, size: int) -> str:
    """The aims that can be judged of what was measured, at the smallest payload."""

    def median(what: str, title: str) -> float:
        return statistics.median(samples[what, title, size].times or [0.0])

    def rate(what: str, title: str) -> float:
        return statistics.median(samples[what, title, size].rates or [0.0])

    query, command = median("query", OURS), median("command", OURS)
    direct = median("query", DIRECT)
    rows = [
        _aim("query, direct, to NATS", direct, median("query", NATS), 1.0),
        _aim("queries, direct, to NATS", rate("queries", NATS), rate("queries", DIRECT), 1.0),
        _aim("query, router, to the bare query", query, median("query", BARE), 1.1),
        _aim("query, router, to gRPC", query, median("query", GRPC), 1.0),
        _aim("informs, router, to NATS", rate("informs", NATS), rate("informs", OURS), 1.0),
        _aim("informs, direct, to NATS", rate("informs", NATS), rate("informs", DIRECT), 1.0),
        _aim("informs together, to NATS", rate("informs", NATS), rate("together", OURS), 1.0),
        _aim("command, to our query", command, query, 3.0),
    ]
    table = _markdown(["time of one", "ratio", "at most", ""], rows)
    return f"**Aims, {_bytes(size)}**\n\n{table}"


def _aim(name: str, ours: float, other: float, most: float) -> Row:
    if not ours or not other:
        return [name, "-", f"{most:.1f}", "not measured"]
    verdict = "met" if ours / other <= most else "missed"
    return [name, f"{ours / other:.2f}", f"{most:.1f}", verdict]


def _bytes(size: int) -> str:
    return f"{size} B" if size < 1024 else f"{size // 1024} kB"
