"""The tray as the working domain knows it: how many places are left on it."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

from rogue.prodigy import Literal

NUMBERS = ("none", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
"""Names of the counts; the domain knows ``one`` by its name."""

MOST_PLACES = len(NUMBERS) - 1
"""Places that a tray may have."""


class TrayError(ValueError):
    """A tray that the domain cannot count."""

    def __init__(self, places: int) -> None:
        self.places = places
        super().__init__(f"a tray of {places} places; expected 1 to {MOST_PLACES}, or no bound")


def tray_counts(places: int | None) -> tuple[str, ...]:
    """The objects of type ``count`` for a tray of so many places; none for one without bounds.

    Raises:
        TrayError: The domain cannot count so far.
    """
    if places is not None and not 1 <= places <= MOST_PLACES:
        raise TrayError(places)
    return () if places is None else NUMBERS[: places + 1]


def tray_facts(places: int | None, carried: int) -> Iterable[Literal]:
    """What is true of a tray of so many places with so many items on it."""
    counts = tray_counts(places)
    for less, more in pairwise(counts):
        yield Literal("one-less", (more, less))
    yield from tray_state(places, carried)


def tray_state(places: int | None, carried: int) -> Iterable[Literal]:
    """Of these facts those that change."""
    if places is None:
        return
    left = max(0, places - carried)
    yield Literal("places-left", (NUMBERS[left],))
    if left == 0:
        yield Literal("tray-full")
