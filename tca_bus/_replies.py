"""The ways back to who asked: a reply to a Zenoh query, or an answer that is published."""

from __future__ import annotations

import logging
from typing import Protocol

import zenoh

from tca_bus._bridge import Answer
from tca_bus._core import Core
from tca_bus._keys import QueryAddress
from tca_bus._presence import PresentModule

logger = logging.getLogger(__name__)


class WayBack(Protocol):
    """Takes the answer to one sending of a request."""

    def send(self, answer: Answer) -> None:
        """Answer; one that cannot be sent any more is logged."""
        ...

    def drop(self) -> None:
        """End without an answer, if none was sent."""
        ...


class ZenohReply:
    """The reply to a Zenoh query."""

    __slots__ = ("_address", "_core", "_query")

    def __init__(self, core: Core, query: zenoh.Query, address: QueryAddress) -> None:
        self._core = core
        self._query = query
        self._address = address

    def send(self, answer: Answer) -> None:
        """Reply, and end the query."""
        data, encoding = answer.payload.data, answer.payload.encoding
        try:
            with self._query:
                if answer.is_error:
                    self._query.reply_err(data, encoding=encoding)
                else:
                    self._query.reply(self._key(), data, encoding=encoding)
        except zenoh.ZError as error:
            logger.warning("answer to %s was not sent: %s", self._address.caller, error)

    def drop(self) -> None:
        """End the query: whoever asked sees that there is no reply."""
        self._query.drop()

    def _key(self) -> str | zenoh.KeyExpr:
        """A concrete key: a tool may have asked with wildcards."""
        if "*" not in str(self._query.key_expr):
            return self._query.key_expr
        core = self._core
        me = PresentModule(core.name, core.incarnation, "", 0, ())
        return core.keys.query(
            me, self._address.name, self._address.caller.replace("*", "anonymous")
        )


class PublishedAnswer:
    """An answer on the key of whoever published the query; its attachment is the request's id."""

    __slots__ = ("_caller", "_core", "_id", "_incarnation")

    def __init__(self, core: Core, caller: str, incarnation: str, id: str) -> None:
        self._core = core
        self._caller = caller
        self._incarnation = incarnation
        self._id = id

    def send(self, answer: Answer) -> None:
        """Publish the answer."""
        core = self._core
        key = core.keys.answer(self._caller, self._incarnation, core.name)
        try:
            core.outlets.at(key).put(answer.payload, self._id.encode())
        except zenoh.ZError as error:
            logger.warning("answer to %s was not sent: %s", self._caller, error)

    def drop(self) -> None:
        """Say nothing: presence tells the caller that its callee is gone."""
