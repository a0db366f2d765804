"""What is wrong with a map as a sentence, and what is none: the errors of a survey."""

from __future__ import annotations

SLACK = 0.3
"""Metres by which what was surveyed may be off: more is no error of measuring."""


def problem(item: str, value: object, expected: str) -> str:
    """Say which item of a map is wrong, what it is, and what it should be."""
    return f"{item} is {str(value)[:120]!r}, expected {expected}"
