"""What is attached to all tasks of a message, and by whom."""

from __future__ import annotations

from collections.abc import Iterator

from tca_bus._attachments import ANY, Catch, Tap
from tca_bus.tasktree._events import Registered


class Registry:
    """Attachments to messages: they end with the module that made them."""

    def __init__(self) -> None:
        self._entries: dict[str, Registered] = {}

    def __contains__(self, id: object) -> bool:
        return id in self._entries

    def __iter__(self) -> Iterator[Registered]:
        return iter(list(self._entries.values()))

    def get(self, id: str) -> Registered | None:
        """The entry of an attachment."""
        return self._entries.get(id)

    def add(self, event: Registered) -> None:
        """Take an attachment; of one id there is one."""
        self._entries[event.id] = event

    def remove(self, id: str) -> Registered | None:
        """Forget an attachment; gives what it was."""
        return self._entries.pop(id, None)

    def taps_of(self, message: str) -> tuple[Tap, ...]:
        """The taps on a message, in the order in which they were made."""
        matching = (entry.what for entry in self if entry.message in {ANY, message})
        return tuple(what for what in matching if isinstance(what, Tap))

    def catches_of(self, message: str) -> Iterator[Catch]:
        """The exception handlers on a message, the newest first."""
        for entry in reversed(self._entries.values()):
            if entry.message in {ANY, message} and isinstance(entry.what, Catch):
                yield entry.what

    def owners(self) -> dict[str, str]:
        """The incarnations that attached something, with their modules' names."""
        return {what.incarnation: what.owner for _, what in self._owned()}

    def owned_by(self, incarnation: str) -> list[str]:
        """The ids of what an incarnation attached."""
        return [id for id, what in self._owned() if what.incarnation == incarnation]

    def _owned(self) -> Iterator[tuple[str, Tap | Catch]]:
        for entry in self:
            if isinstance(entry.what, Tap | Catch) and entry.what.incarnation:
                yield entry.id, entry.what
