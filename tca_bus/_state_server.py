"""Answering plain Zenoh gets on keys under which states are published."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import zenoh
from zenoh.handlers import Callback

from tca_bus._bridge import Mailbox
from tca_bus._core import Core
from tca_bus._serving import MOST_WAITING
from tca_bus._wire import Payload

Lookup = Callable[[str], Iterable[tuple[str, Payload]]]
"""Gives the states that may match a key expression, each with its own key."""


@dataclass(frozen=True)
class StateServer:
    """Answers gets on ``key`` with the states that match; has no other side to it."""

    core: Core
    key: str
    lookup: Lookup

    def begin(self) -> None:
        """Declare the queryable."""
        box = Mailbox[zenoh.Query](
            self._reply, size=MOST_WAITING, refuse=lambda query: query.drop()
        )
        self.core.tally.counters[f"gets of {self.key}"] = lambda: box.dropped
        self.core.session.declare_queryable(self.key, Callback(box.post))

    def _reply(self, query: zenoh.Query) -> None:
        with query:
            for name, payload in self.lookup(str(query.key_expr)):
                key = zenoh.KeyExpr(name)
                if query.key_expr.intersects(key):
                    query.reply(key, payload.data, encoding=payload.encoding)
