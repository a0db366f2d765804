"""Texts for people: as they fit into a drawing, and without words that are for programs."""

from __future__ import annotations

import re
import unicodedata

_FAILURE_NAME = re.compile(r"\b[a-z]+(?:_[a-z]+)+: ")

_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def clean(text: str) -> str:
    """Return ``text`` with every character that XML 1.0 forbids replaced by U+FFFD."""
    return _NOT_XML.sub("\ufffd", text)


def cells(text: str) -> int:
    """Return how many columns ``text`` takes in a font of fixed width."""
    return sum(
        0 if unicodedata.combining(one) else 2 if unicodedata.east_asian_width(one) in "WF" else 1
        for one in text
    )


def shortened(text: str, most: int) -> str:
    """Return at most ``most`` columns of ``text``, with an ellipsis where something is left out."""
    if cells(text) <= most:
        return text
    kept = ""
    for one in text:
        if cells(kept + one) >= most:
            break
        kept += one
    return f"{kept}…"


def wrapped(text: str, most: int, *, lines: int) -> list[str]:
    """Break ``text`` at blanks into at most so many lines of at most ``most`` columns."""
    found: list[str] = []
    for word in text.split():
        if found and cells(f"{found[-1]} {word}") <= most:
            found[-1] += f" {word}"
        else:
            found.append(word)
    if len(found) > lines:
        found[lines - 1 :] = [" ".join(found[lines - 1 :])]
    return [shortened(line, most) for line in found]


def plain(reason: str) -> str:
    """Return a reason without the names that programs have for failures: ``no_answer: ``."""
    return _FAILURE_NAME.sub("", reason)
