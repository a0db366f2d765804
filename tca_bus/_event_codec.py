"""Events as JSON under the names of their kinds, as journals keep them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Generic, TypeVar

from pydantic import TypeAdapter
from pydantic_core import to_json

E = TypeVar("E")


class EventCodec(Generic[E]):
    """Writes and reads the events of these classes.

    A kind is the name of the class behind ``prefix``, which keeps those of two codecs apart.
    """

    def __init__(self, classes: Iterable[type[E]], *, prefix: str = "") -> None:
        self._names = {each: f"{prefix}{each.__name__}" for each in classes}
        self._adapters = {name: TypeAdapter(each) for each, name in self._names.items()}

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of events."""
        return tuple(self._adapters)

    def encode(self, event: E) -> tuple[str, str]:
        """Give the kind of an event and its fields as JSON."""
        return self._names[type(event)], to_json(event, inf_nan_mode="constants").decode()

    def decode(self, kind: str, body: str) -> E:
        """Rebuild an event.

        Raises:
            ValueError: There is no such kind, or the fields do not fit it.
        """
        adapter = self._adapters.get(kind)
        if adapter is None:
            known = ", ".join(self._adapters)
            raise ValueError(f"unknown kind of event {kind!r}, expected one of {known}")
        return adapter.validate_json(body)
