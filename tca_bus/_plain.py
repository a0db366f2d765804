"""Sending by wire name with plain data, for tools that have no message type at hand."""

from __future__ import annotations

import asyncio
from typing import Any, Literal, Unpack

from tca_bus._errors import BusGoneError, InvalidMessageError, NoHandlerError
from tca_bus._handle import TaskHandle
from tca_bus._lifecycle import Lifecycle
from tca_bus._messages import MessageClass
from tca_bus._options import CHUNK_EXPECTED, CHUNK_PATTERN
from tca_bus._sending import SendOptions, submission
from tca_bus._traits import TaskTraits
from tca_bus._wire import ANYTHING, REPLY_SUFFIX, Payload, decode_plain, encode_json


class PlainMessages(Lifecycle):
    """Sends what is named by a string; the receiver says whether the data fit.

    Raises:
        InvalidMessageError: From any sending method, the name cannot be that of a message.
    """

    async def query_json(
        self, name: str, data: dict[str, Any], *, to: str | None = None, timeout: float = 10.0
    ) -> Any:
        """Ask by wire name; gives the answer as JSON values. Raises as `Module.query` does."""
        payload = _encode(name, data)
        answer = await self._parts.caller.call(name, payload, to=to, timeout=timeout)
        return decode_plain(answer, name + REPLY_SUFFIX)

    async def inform_json(self, name: str, data: dict[str, Any]) -> None:
        """Inform by wire name; raises as `Module.inform` does."""
        await self._inform(name, _encode(name, data))

    async def broadcast_json(self, name: str, data: dict[str, Any]) -> None:
        """Broadcast by wire name."""
        self._parts.topics.publish(MessageClass.BROADCAST, name, _encode(name, data))

    async def submit_json(
        self,
        name: str,
        data: dict[str, Any],
        *,
        task_class: Literal["goal", "command"],
        revision: int | None = None,
        traits: TaskTraits | None = None,
        **options: Unpack[SendOptions],
    ) -> TaskHandle[Any]:
        """Make a root node by wire name; the result comes as JSON values.

        ``traits`` are the defaults of the message's type, which the card of the module that
        handles it tells. Raises as `Module.expand` does, and InvalidMessageError for an id that
        cannot be one.
        """
        task = submission(
            name,
            data,
            options,
            task_class=task_class,
            revision=revision,
            traits=traits or TaskTraits(),
            sender=self.name,
        )
        timeout = options.get("timeout", 10.0)
        return await self._parts.sender.submit(task, ANYTHING, timeout=timeout)

    async def _inform(self, name: str, *payloads: Payload) -> None:
        parts = self._parts
        if not parts.core.session.can_send:
            await self._until_connected()
        table = parts.core.presence.table
        if not table.providers(name):
            raise NoHandlerError(name, table.known_messages())
        for payload in payloads:
            parts.topics.publish(MessageClass.INFORM, name, payload)

    async def _until_connected(self) -> None:
        try:
            async with asyncio.timeout(self.options.connect_timeout):
                await self._parts.core.session.connected()
        except TimeoutError as error:
            raise BusGoneError(self.options.connect, "it was lost") from error


def _encode(name: str, data: dict[str, Any]) -> Payload:
    if not CHUNK_PATTERN.fullmatch(name):
        raise InvalidMessageError(name[:100], [f"name: expected {CHUNK_EXPECTED}"])
    return encode_json(name, data)
