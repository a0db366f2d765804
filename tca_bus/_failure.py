"""A failure as a value that crosses processes whole."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


class Failure(BaseModel):
    """Why something failed: a name, a sentence, data, the node and a cause.

    ``name`` is what programs compare (``door_blocked``), ``text`` what people read. ``message``
    is the wire name of the message whose handler failed, ``node`` the id of its task node.
    ``kinds`` are the names of the exception and its bases, by which handlers catch it;
    ``uncaught`` says that it was offered to all exception handlers above and none took it.
    """

    model_config = ConfigDict(frozen=True, ser_json_inf_nan="constants")

    name: str = Field(min_length=1, max_length=200)
    text: str
    data: dict[str, Any] | None = None
    message: str | None = None
    node: str | None = None
    module: str | None = None
    kinds: tuple[str, ...] = ()
    uncaught: bool = False
    cause: Failure | None = None

    def is_a(self, exception: str) -> bool:
        """Whether a handler of the named exception takes it; ``*`` takes all."""
        return exception in {"*", self.name, *self.kinds}

    def chain(self) -> list[Failure]:
        """This failure and its causes, the outermost first."""
        links: list[Failure] = []
        link: Failure | None = self
        while link is not None:
            links.append(link)
            link = link.cause
        return links

    def sentence(self) -> str:
        """The whole chain on one line."""
        return "; because ".join(f"{link.text} ({link.name})" for link in self.chain())
