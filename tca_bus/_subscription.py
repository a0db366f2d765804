"""A bounded stream of messages."""

from __future__ import annotations

from types import TracebackType
from typing import Generic, Self, TypeVar

M = TypeVar("M")


class Subscription(Generic[M]):
    """Messages as they come: an async context manager and an async iterator.

    Holds at most ``size`` messages; when full the oldest is dropped and ``dropped`` counts it.
    """

    dropped: int = 0

    async def __aenter__(self) -> Self:
        raise NotImplementedError

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        raise NotImplementedError

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> M:
        raise NotImplementedError
