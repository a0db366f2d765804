"""Where a handled message came from."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tca_bus._module import Module


class Context:
    """Where a handled message came from.

    ``sender`` is the name of the sending module, taken from the key; ``id`` that of the request.
    """

    def __init__(self, module: Module, *, sender: str, id: str) -> None:
        self.module = module
        self.sender = sender
        self.id = id
