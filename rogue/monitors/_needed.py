"""Which things of the world the pending plans depend on. Pure.

Source: Veloso, Pollack & Cox, *Rationale-based monitoring for planning in dynamic environments*
(AIPS 1998): a monitor lives as long as the plan has a reason for it.
"""

from __future__ import annotations

import enum
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from rogue.memory import Hold
from rogue.messages import DeliveryRequest
from rogue.outcomes import Thing, Trouble


class Kind(enum.StrEnum):
    """What kind of thing is watched."""

    DOOR = "door"
    """Whether the door of a room is open."""
    ITEM = "item"
    """Whether an item is where the plan has it: on the tray, or not yet with its user."""
    PERSON = "person"
    """Whether somebody is in again at a room where nobody was."""
    BATTERY = "battery"
    """Whether the robot can go on."""


@dataclass(frozen=True, slots=True, order=True)
class Monitor:
    """One thing that is watched; ``subject`` is a room, or user and item; empty for the battery."""

    kind: Kind
    subject: str = ""

    def __str__(self) -> str:
        return f"{self.kind} {self.subject}".strip()


Needed = Mapping[Monitor, tuple[str, ...]]
"""The monitors that are needed, each with the ids of the requests that depend on it."""


def needed(
    requests: Iterable[DeliveryRequest], tray: Collection[Thing], holds: Iterable[Hold]
) -> Needed:
    """The monitors that open requests need.

    Args:
        requests: all that are open, those that are put off among them.
        tray: user and item of what is on the tray.
        holds: what is put off, and for which trouble.
    """
    absent = {hold.request: hold.room for hold in holds if hold.trouble is Trouble.NOBODY}
    found: dict[Monitor, list[str]] = {}
    for request in requests:
        for monitor in _of(request, tray, absent.get(request.id)):
            found.setdefault(monitor, []).append(request.id)
    return {monitor: tuple(found[monitor]) for monitor in sorted(found)}


def subject_of(thing: Thing) -> str:
    """An item as a monitor names it."""
    return " ".join(thing)


def _of(request: DeliveryRequest, tray: Collection[Thing], absent: str | None) -> set[Monitor]:
    thing = (request.user, request.item)
    rooms = {request.destination} if thing in tray else {request.pickup, request.destination}
    found = {Monitor(Kind.DOOR, room) for room in rooms}
    found |= {Monitor(Kind.ITEM, subject_of(thing)), Monitor(Kind.BATTERY)}
    if absent is not None:
        found.add(Monitor(Kind.PERSON, absent))
    return found
