"""What a finger server says of a user: the account's own lines, and the user's plan file.

A plan file is free text; lines of it that are ``key: value`` with one of these keys are read, in
any case, the later one counting where a key comes twice::

    Room: 5303
    Pickup delivermail: 5309
    Deliver pickupcoffee: 5313
    Deadline: 30m

``Office`` is another word for ``Room``. ``Login``, ``Name`` and ``Office`` are taken from the
server's own lines too, several of which may share a line, apart by a tab or two blanks.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from rogue.messages import NAME_LENGTH, End

NOBODY = "???"
"""What servers print for the name of a user that does not exist."""

_GAP = re.compile(r"\t+| {2,}")
_LOGIN, _NAME, _ROOM = {"login", "login name"}, {"name", "in real life"}, {"room", "office"}


@dataclass(slots=True)
class PlanFile:
    """What is known of a user by finger: texts as they were written, ends by (end, item)."""

    name: str | None = None
    room: str | None = None
    deadline: str | None = None
    ends: dict[tuple[End, str], str] = field(default_factory=dict)


def read_plan(reply: str, user: str) -> PlanFile | None:
    """What a finger server's reply says of ``user``; None if it knows no such user.

    Lines with characters that do not print are passed over (RFC 1288, section 3.3), and so is
    what is said of other users.
    """
    found, known, mine = PlanFile(), False, True
    for key, value in _entries(reply):
        if key in _LOGIN:
            mine = value.split()[0].lower() == user
            known |= mine
        elif mine and value != NOBODY:
            known |= _take(found, key, value[:NAME_LENGTH])
        elif mine and key in _NAME:
            return None
    return found if known else None


def _take(found: PlanFile, key: str, value: str) -> bool:
    """Take in an entry; says whether it is one of those that are read."""
    end, _, item = key.partition(" ")
    if key in _NAME:
        found.name = value
    elif key in _ROOM:
        found.room = value
    elif key == "deadline":
        found.deadline = value
    elif item and end == "pickup":
        found.ends["pickup", item] = value
    elif item and end == "deliver":
        found.ends["deliver", item] = value
    else:
        return False
    return True


def _entries(reply: str) -> Iterator[tuple[str, str]]:
    in_plan = False
    for line in reply.split("\n"):
        text = line.rstrip("\r")
        if not text.replace("\t", " ").isprintable():
            continue
        for part in [text] if in_plan else _GAP.split(text):
            key, _, value = part.partition(":")
            key, value = " ".join(key.lower().split()), value.strip()
            if key == "plan" and not in_plan:
                in_plan = True
            elif key and value:
                yield key, value
