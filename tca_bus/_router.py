"""A Zenoh router hosted in this process."""

from __future__ import annotations

from types import TracebackType
from typing import Self


class Router:
    """A Zenoh router: an async context manager; ``endpoint`` is where it really listens.

    Port 0 picks a free port. Raises ConfigError when the port is in use.
    """

    endpoint: str

    def __init__(self, listen: str = "tcp/127.0.0.1:7447") -> None:
        self.listen = listen

    async def __aenter__(self) -> Self:
        raise NotImplementedError

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        raise NotImplementedError
