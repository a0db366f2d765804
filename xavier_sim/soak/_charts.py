"""Charts as SVG text: curves, points and bars over two axes. No more than a report needs."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from html import escape

Point = tuple[float, float]

WIDTH, HEIGHT = 560, 300
LEFT, RIGHT, TOP, BOTTOM = 56, 16, 34, 44
COLOURS = ("#2f6fb0", "#c8553d", "#4f8a4b", "#8a6fb0")
BAR_HEIGHT = 22
TICKS = 6
"""Ticks of an axis, at most one more."""


@dataclass(frozen=True)
class Axis:
    """What an axis shows: its title, and the values at its ends."""

    title: str
    low: float
    high: float

    @classmethod
    def over(cls, title: str, values: Iterable[float], *, low: float = 0.0) -> Axis:
        """An axis from ``low`` to a round number beyond all values."""
        most = max(values, default=low)
        step = nice_step(max(most - low, 1e-9) / TICKS)
        return cls(title, low, low + step * max(1, math.ceil((most - low) / step - 1e-9)))

    def share(self, value: float) -> float:
        """Where a value lies, 0 to 1; what is beyond an end lies on it."""
        return min(1.0, max(0.0, (value - self.low) / (self.high - self.low)))

    def ticks(self) -> list[float]:
        """Round values from end to end."""
        step = nice_step((self.high - self.low) / TICKS)
        first = math.ceil(self.low / step - 1e-9)
        last = math.floor(self.high / step + 1e-9)
        return [step * index for index in range(first, last + 1)]


def nice_step(least: float) -> float:
    """The smallest 1, 2 or 5 times a power of ten that is no less."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= least)


def curves(title: str, x: Axis, y: Axis, lines: Mapping[str, Sequence[Point]]) -> str:
    """Curves with their names."""
    marks = [
        f'<polyline fill="none" stroke="{colour}" stroke-width="1.8" points="{_path(x, y, line)}"/>'
        for colour, line in zip(_colours(len(lines)), lines.values(), strict=True)
    ]
    return _frame(title, x, y, [*marks, *_legend(list(lines))])


def points(title: str, x: Axis, y: Axis, groups: Mapping[str, Sequence[Point]]) -> str:
    """Points in groups with their names."""
    marks = [
        f'<circle cx="{_across(x, a):.1f}" cy="{_up(y, b):.1f}" r="2" fill="{colour}" '
        'fill-opacity="0.55"/>'
        for colour, group in zip(_colours(len(groups)), groups.values(), strict=True)
        for a, b in group
    ]
    return _frame(title, x, y, [*marks, *_legend(list(groups))])


def columns(title: str, x: Axis, y: Axis, bars: Sequence[tuple[float, float, float]]) -> str:
    """A histogram: bars from one value to another, of a height."""
    marks = [
        f'<rect x="{_across(x, low):.1f}" y="{_up(y, count):.1f}" '
        f'width="{max(1.0, _across(x, high) - _across(x, low) - 1):.1f}" '
        f'height="{_up(y, y.low) - _up(y, count):.1f}" fill="{COLOURS[0]}"/>'
        for low, high, count in bars
    ]
    return _frame(title, x, y, marks)


def bars(title: str, counts: Mapping[str, float]) -> str:
    """Horizontal bars with names and values, in the order given."""
    height = TOP + BAR_HEIGHT * max(1, len(counts)) + 10
    most, start = max([*counts.values(), 1.0]), 150
    rows = []
    for row, (name, count) in enumerate(counts.items()):
        y = TOP + row * BAR_HEIGHT
        width = (WIDTH - start - 60) * count / most
        rows += [
            _text(start - 8, y + 14, name, anchor="end"),
            f'<rect x="{start}" y="{y + 3}" width="{width:.1f}" height="15" fill="{COLOURS[0]}"/>',
            _text(start + width + 6, y + 14, f"{count:g}"),
        ]
    return _svg(title, height, rows or [_text(start, TOP + 14, "none")])


def plan_view(
    title: str, walls: Sequence[Sequence[float]], groups: Mapping[str, Sequence[Point]]
) -> str:
    """Points in groups on a floor; one that is higher than wide has north to its right.

    Args:
        title: of the chart.
        walls: x and y of both ends, metres, y upwards.
        groups: points in metres, by the names of their groups.
    """
    low_x, high_x = _ends([x for wall in walls for x in (wall[0], wall[2])])
    low_y, high_y = _ends([y for wall in walls for y in (wall[1], wall[3])])
    wide, high = high_x - low_x, high_y - low_y
    turned = high > wide
    scale = (WIDTH - 2 * RIGHT) / max(wide, high)

    def spot(x: float, y: float) -> str:
        across, down = (y - low_y, x - low_x) if turned else (x - low_x, high_y - y)
        return f"{RIGHT + scale * across:.1f} {TOP + scale * down:.1f}"

    path = "".join(f"M{spot(a, b)}L{spot(c, d)}" for a, b, c, d in walls)
    marks = [f'<path d="{path}" fill="none" stroke="currentColor" stroke-opacity="0.6"/>']
    for colour, group in zip(_colours(len(groups)), groups.values(), strict=True):
        marks.append(_dots(colour, [spot(*point) for point in group]))
    note = ", north to the right" if turned else ""
    height = round(TOP + scale * min(wide, high) + RIGHT)
    return _svg(f"{title}{note}", height, [*marks, *_legend(list(groups))])


def _ends(values: Sequence[float]) -> tuple[float, float]:
    return min(values), max(values)


def _dots(colour: str, spots: Sequence[str]) -> str:
    path = "".join(f"M{spot}h0" for spot in spots)
    return (
        f'<path d="{path}" stroke="{colour}" stroke-width="7" stroke-linecap="round" '
        'stroke-opacity="0.55"/>'
    )


def _frame(title: str, x: Axis, y: Axis, marks: list[str]) -> str:
    foot, side = HEIGHT - BOTTOM, WIDTH - RIGHT
    parts = [f'<path d="M{LEFT} {TOP}V{foot}H{side}" fill="none" stroke="currentColor"/>']
    parts += [
        _text(_across(x, value), foot + 16, f"{value:g}", anchor="middle") for value in x.ticks()
    ]
    for value in y.ticks():
        at = _up(y, value)
        parts += [
            _text(LEFT - 6, at + 4, f"{value:g}", anchor="end"),
            f'<path d="M{LEFT} {at:.1f}H{side}" stroke="currentColor" stroke-opacity="0.15"/>',
        ]
    parts.append(_text((LEFT + side) / 2, HEIGHT - 8, x.title, anchor="middle"))
    turned = f'transform="rotate(-90 14 {(TOP + foot) / 2:.0f})"'
    parts.append(_text(14, (TOP + foot) / 2, y.title, anchor="middle", more=turned))
    return _svg(title, HEIGHT, [*parts, *marks])


def _legend(names: list[str]) -> list[str]:
    if len(names) < 2:
        return []
    parts, at = list[str](), float(WIDTH - RIGHT)
    for name, colour in reversed(list(zip(names, _colours(len(names)), strict=True))):
        at -= 7.0 * len(name) + 22
        parts += [
            f'<rect x="{at:.0f}" y="{TOP - 14}" width="10" height="10" fill="{colour}"/>',
            _text(at + 14, TOP - 5, name),
        ]
    return parts


def _svg(title: str, height: float, parts: list[str]) -> str:
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {height}" role="img" '
        'font-family="sans-serif" font-size="12" fill="currentColor">'
        f"<title>{escape(title)}</title>"
    )
    return "\n".join([head, _text(LEFT, 14, title, more='font-weight="bold"'), *parts, "</svg>"])


def _text(x: float, y: float, text: str, *, anchor: str = "start", more: str = "") -> str:
    where = f'x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}"'
    return f"<text {where} {more}>{escape(text)}</text>"


def _path(x: Axis, y: Axis, line: Sequence[Point]) -> str:
    return " ".join(f"{_across(x, a):.1f},{_up(y, b):.1f}" for a, b in line)


def _across(x: Axis, value: float) -> float:
    return LEFT + (WIDTH - LEFT - RIGHT) * x.share(value)


def _up(y: Axis, value: float) -> float:
    return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * y.share(value)


def _colours(count: int) -> list[str]:
    return [COLOURS[index % len(COLOURS)] for index in range(count)]
