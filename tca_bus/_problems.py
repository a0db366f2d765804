"""What a validator found, in sentences."""

from __future__ import annotations

from typing import Any

from pydantic import ValidationError

MOST_PROBLEMS = 8
"""How many problems of one payload an error names."""


def problems_of(error: ValidationError) -> list[str]:
    """One sentence for each problem: the field, what was expected, what was there."""
    found = error.errors(include_url=False, include_context=False)
    sentences = [_sentence(problem) for problem in found[:MOST_PROBLEMS]]
    if len(found) > MOST_PROBLEMS:
        sentences.append(f"and {len(found) - MOST_PROBLEMS} more")
    return sentences


def _sentence(problem: Any) -> str:
    where = ".".join(str(part) for part in problem["loc"]) or "payload"
    text = problem["msg"][:1].lower() + problem["msg"][1:]
    shown = repr(problem["input"])
    if len(shown) > 80:
        shown = shown[:77] + "..."
    return f"{where}: {text}" if problem["type"] == "missing" else f"{where}: {text}, got {shown}"
