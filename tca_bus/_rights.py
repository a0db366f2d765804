"""The rights that a policy gives, and the patterns that say for what.

A pattern is a name in which ``*`` stands for any letters, and for some rights an ``@`` and the
pattern of a module: ``navigate*@rogue``. The messages of the bus itself begin with ``tca.``; only
patterns that begin so match them.
"""

from __future__ import annotations

import enum
import re
from functools import cache

BUS_PREFIX = "tca."
"""Begins the names of the messages of the bus itself."""

PATTERN_EXPECTED = "a name in which '*' stands for any letters, such as 'xavier*'"
OWNED_EXPECTED = f"{PATTERN_EXPECTED}, or one with '@' and a module, such as 'xavier*@rogue'"

_NAME_PATTERN = re.compile(r"^(?!.*\*\*)[A-Za-z0-9*][A-Za-z0-9._*-]{0,99}$")


class Right(enum.StrEnum):
    """Something that a policy allows or refuses."""

    SEND = "send"
    """Send an inform, broadcast, query, goal or command, by its name."""
    SERVE = "serve"
    """Handle an inform, query, goal or command, by its name."""
    LISTEN = "listen"
    """Hear a broadcast or inform that is not sent to the module, by its name and sender."""
    WATCH = "watch"
    """See the tasks of other modules, by the sender's name: states, lists, history."""
    KILL = "kill"
    """Kill tasks of others, by message and sender."""
    SUSPEND = "suspend"
    """Suspend and resume tasks of others, by message and sender."""
    PRIORITISE = "prioritise"
    """Change the priority of tasks of others, by message and sender."""
    EDIT = "edit"
    """Change a tree below tasks of others, by message and sender: children, constraints,
    exception handlers, retries."""
    TAP = "tap"
    """Be told of, or hold up, tasks of others, by message and sender."""
    MONITOR = "monitor"
    """Start a monitor, by its name."""
    LOCK = "lock"
    """Hold, reserve, lock and unlock a thing or the resource of a module's handlers, by its name
    and, where it has one, its module."""
    READ = "read"
    """Get and watch a shared variable, by its name."""
    WRITE = "write"
    """Set a shared variable, by its name."""

    @property
    def is_owned(self) -> bool:
        """Whether what it is about has an owner, and a pattern may name one."""
        return self in OWNED


OWNED = frozenset(
    {
        Right.LISTEN,
        Right.KILL,
        Right.SUSPEND,
        Right.PRIORITISE,
        Right.EDIT,
        Right.TAP,
        Right.LOCK,
    }
)

OF_THINGS = frozenset({Right.LOCK, Right.READ, Right.WRITE})
"""Those that are about the name of a thing, not of a message or a module."""

OWN_TASKS = OWNED - {Right.LISTEN} | {Right.WATCH}
"""What every module may do with the tasks that it sent itself, and its handlers' resources."""


def is_pattern(text: str) -> bool:
    """Whether a text is the pattern of a name."""
    return _NAME_PATTERN.fullmatch(text) is not None


def matches(pattern: str, name: str) -> bool:
    """Whether the name of a thing fits a pattern."""
    return _compiled(pattern).fullmatch(name) is not None


def matches_message(pattern: str, name: str) -> bool:
    """Whether the name of a message fits; see the module's first lines for ``tca.``."""
    of_the_bus = name.startswith(BUS_PREFIX) and not pattern.startswith(BUS_PREFIX)
    return not of_the_bus and matches(pattern, name)


def matches_module(pattern: str, module: str) -> bool:
    """Whether the name of a module, with or without what follows a ``-``, fits a pattern."""
    return matches(pattern, module) or matches(f"{pattern}-*", module)


def as_chunk(pattern: str) -> str:
    """The pattern as one chunk of a Zenoh key expression."""
    return pattern if pattern == "*" else pattern.replace("*", "$*")


def as_module_chunks(pattern: str) -> list[str]:
    """The pattern of a module as chunks, with and without what follows a ``-``."""
    chunk = as_chunk(pattern)
    return [chunk] if chunk.endswith("*") else [chunk, f"{chunk}-$*"]


@cache
def _compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(".*".join(re.escape(part) for part in pattern.split("*")), re.DOTALL)
