"""A page of text to draw on: eight dots in each character, and characters over them."""

from __future__ import annotations

import math

from navigate.view._ink import Point, Window

BLANK = 0x2800
DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""The bits of a character's dots, by row and column."""


class Braille:
    """A window of the floor in so many columns and rows of characters.

    Args:
        window: the part of the floor to show, in metres; shown whole, in the middle.
        columns: characters across.
        rows: characters down.
    """

    def __init__(self, window: Window, columns: int, rows: int) -> None:
        self.columns, self.rows = columns, rows
        self.scale = min(2 * columns / window.width, 4 * rows / window.height)
        self._middle = ((window.x0 + window.x1) / 2, (window.y0 + window.y1) / 2)
        self._dots: dict[tuple[int, int], int] = {}
        self._signs: dict[tuple[int, int], str] = {}

    def dot(self, point: Point) -> None:
        """Set the dot at a point in metres."""
        across, down = self._on_page(point)
        place = (down // 4, across // 2)
        self._dots[place] = self._dots.get(place, 0) | DOTS[down % 4][across % 2]

    def line(self, one: Point, other: Point) -> None:
        """Set the dots along a straight line."""
        steps = int(max(abs(other[0] - one[0]), abs(other[1] - one[1])) * self.scale) + 1
        for step in range(steps + 1):
            part = step / steps
            self.dot((one[0] + part * (other[0] - one[0]), one[1] + part * (other[1] - one[1])))

    def sign(self, point: Point, character: str) -> None:
        """Put a character over the dots at a point in metres."""
        across, down = self._on_page(point)
        self._signs[down // 4, across // 2] = character

    def lines(self) -> list[str]:
        """The page, line by line."""
        return [
            "".join(self._character((row, column)) for column in range(self.columns))
            for row in range(self.rows)
        ]

    def _character(self, place: tuple[int, int]) -> str:
        if place in self._signs:
            return self._signs[place]
        dots = self._dots.get(place)
        return chr(BLANK + dots) if dots else " "

    def _on_page(self, point: Point) -> tuple[int, int]:
        x, y = point[0] - self._middle[0], point[1] - self._middle[1]
        across, down = self.columns + x * self.scale, 2 * self.rows - y * self.scale
        return math.floor(across), math.floor(down)
