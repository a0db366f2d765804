"""Where a module publishes: one declared Zenoh publisher per key, kept for the next message."""

from __future__ import annotations

import logging
from collections import OrderedDict
from functools import lru_cache

import zenoh

from tca_bus._session import Session
from tca_bus._wire import Payload

logger = logging.getLogger(__name__)

MOST_OUTLETS = 8192
"""Declared publishers; the one that was used least recently is given up for a new one."""


@lru_cache(maxsize=1024)
def _encoding(text: str) -> zenoh.Encoding:
    return zenoh.Encoding(text)


class Outlet:
    """A declared publisher on one key."""

    __slots__ = ("_is_heard", "_publisher")

    def __init__(self, publisher: zenoh.Publisher) -> None:
        self._publisher = publisher
        self._is_heard = False

    def put(self, payload: Payload, attachment: bytes) -> None:
        """Publish."""
        data, encoding = payload
        self._publisher.put(data, encoding=_encoding(encoding), attachment=attachment)

    @property
    def is_heard(self) -> bool:
        """Whether somebody has been seen to listen here.

        False for an instant after the first use of a key, since Zenoh has to ask around, and for
        good where a router's rules hide the listener.
        """
        if not self._is_heard:
            self._is_heard = self._publisher.matching_status
        return self._is_heard

    def end(self, session: Session) -> None:
        """Undeclare the publisher."""
        session.undeclare(self._publisher)


class Outlets:
    """The outlets of one session.

    Those that ``block`` drop nothing when the link is congested.
    """

    def __init__(self, session: Session, *, block: bool = True, most: int = MOST_OUTLETS) -> None:
        self._session = session
        self._control = zenoh.CongestionControl.BLOCK if block else zenoh.CongestionControl.DROP
        self._most = most
        self._by_key: OrderedDict[str, Outlet] = OrderedDict()

    def at(self, key: str) -> Outlet:
        """The outlet at a key, declared when there is none yet."""
        outlet = self._by_key.get(key)
        if outlet is None:
            return self._declare(key)
        self._by_key.move_to_end(key)
        return outlet

    def forget(self, key: str) -> None:
        """Give up the outlet at a key, if there is one."""
        outlet = self._by_key.pop(key, None)
        if outlet is not None:
            outlet.end(self._session)

    def forget_module(self, incarnation: str) -> None:
        """Give up all outlets to a module that is gone."""
        for key in [key for key in self._by_key if f"/{incarnation}/" in key]:
            self.forget(key)

    def _declare(self, key: str) -> Outlet:
        if len(self._by_key) >= self._most:
            self.forget(next(iter(self._by_key)))
        publisher = self._session.declare_publisher(key, congestion_control=self._control)
        outlet = self._by_key[key] = Outlet(publisher)
        return outlet

    def __len__(self) -> int:
        return len(self._by_key)
