"""Drawings of what the navigator sees, believes and wants, beside how things really stand."""

from navigate.view._svg import draw_svg
from navigate.view._text import draw_text

__all__ = [
    "draw_svg",
    "draw_text",
]
