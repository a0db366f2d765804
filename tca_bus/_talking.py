"""What goes straight from module to module: queries, informs, broadcasts, and listening."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from itertools import groupby
from typing import TypeVar

from tca_bus._errors import TimedOutError
from tca_bus._messages import Broadcast, Inform, Message, MessageClass, MultiQuery, Query
from tca_bus._multi import Answers
from tca_bus._plain import PlainMessages
from tca_bus._presence import PresenceChange, PresentModule
from tca_bus._protocol import TaskStatus
from tca_bus._streams import Streams
from tca_bus._subscription import Subscription
from tca_bus._types import answer_adapter
from tca_bus._wire import decode_answer, encode_message, encode_messages

R = TypeVar("R")
M = TypeVar("M", bound=Message)


class Talking(PlainMessages):
    """Sends and hears what does not pass through central."""

    async def query(
        self, message: Query[R], *, to: str | PresentModule | None = None, timeout: float = 10.0
    ) -> R:
        """Ask the module that handles the message, or module ``to``; gives its answer.

        Sent again by itself over a restart of the router; the callee handles it once.

        Raises:
            NoHandlerError: No module here handles it.
            InvalidMessageError: It, or the answer, does not fit; a matter of versions.
            HandlerFailedError: The handler raised; ``failure`` says what.
            RefusedError: The callee will not; a `BusyError` when it has too much to do.
            PeerLostError: The callee died before it answered.
            TimedOutError: No answer within ``timeout`` wall seconds.
            BusGoneError: The router was away for the rest of that time.
        """
        kind = type(message)
        answer = await self._parts.caller.call(
            kind.wire_name, encode_message(message), to=to, timeout=timeout
        )
        return decode_answer(answer, answer_adapter(kind), kind.wire_name, revision=kind.revision)  # type: ignore[no-any-return]

    def query_all(
        self, message: MultiQuery[R], *, most: int | None = None, timeout: float = 10.0
    ) -> Answers[R]:
        """Ask all modules that handle the message; the answers come fastest first.

        Ends after ``most`` answers, after ``timeout`` wall seconds, or when all have answered or
        failed. One that fails does not keep the others from answering; the object says how many
        were asked, who answered, who failed and with what, and who is missing.

        Raises:
            ConfigError: ``most`` is below 1.
        """
        return Answers(lambda: self._parts.caller, message, most=most, timeout=timeout)

    async def inform(self, message: Inform) -> None:
        """Tell all modules that handle the message; returns when it is sent.

        Raises:
            NoHandlerError: No module here handles it.
            BusGoneError: The router is away and did not come back within ``connect_timeout``.
        """
        await self._inform(message.wire_name, encode_message(message))

    async def inform_many(self, messages: Sequence[Inform]) -> None:
        """Tell many things at once; they arrive in order, each as if it had been sent alone.

        Neighbours of one type travel together, which costs a fraction of sending each. Of those
        that travel together a receiver takes all, or none if one does not fit.

        Raises as `inform` does; what came before the message that nobody handles was sent.
        """
        for name, together in groupby(messages, key=lambda message: message.wire_name):
            await self._inform(name, *encode_messages(list(together)))

    async def broadcast(self, message: Broadcast) -> None:
        """Tell everybody who listens; lost, and counted, while the router is away."""
        payload = encode_message(message)
        self._parts.topics.publish(MessageClass.BROADCAST, message.wire_name, payload)

    async def broadcast_many(self, messages: Sequence[Broadcast]) -> None:
        """Tell many things at once to everybody who listens; see `inform_many`."""
        for name, together in groupby(messages, key=lambda message: message.wire_name):
            for payload in encode_messages(list(together)):
                self._parts.topics.publish(MessageClass.BROADCAST, name, payload)

    def subscribe(self, message_type: type[M], *, size: int = 256) -> Subscription[M]:
        """Listen to a broadcast or inform type, whoever sends it."""
        return self._streams.messages(message_type, size=size)

    def watch_modules(self) -> Subscription[PresenceChange]:
        """Stream the comings and losses of modules, beginning with those that are there."""
        return self._streams.modules()

    def watch_statuses(self, *, sender: str = "*", size: int = 1024) -> Subscription[TaskStatus]:
        """Stream task states as central publishes them, of one sender or of all."""
        return self._streams.statuses(sender, size=size)

    def modules(self) -> list[PresentModule]:
        """The modules on the bus, this one among them, by name."""
        return self._parts.core.presence.table.modules()

    async def wait_for(self, *messages: type[Message] | str, timeout: float) -> None:
        """Wait until a provider of each message is present.

        Raises:
            TimedOutError: Not within ``timeout`` wall seconds; it names what is missing.
        """
        names = [name if isinstance(name, str) else name.wire_name for name in messages]
        presence = self._parts.core.presence

        def missing() -> list[str]:
            return [name for name in names if not presence.table.has_provider(name)]

        try:
            async with asyncio.timeout(timeout):
                await presence.until(lambda: not missing())
        except TimeoutError as error:
            what = f"a module that handles {', '.join(map(repr, missing()))}"
            raise TimedOutError(what, timeout) from error

    @property
    def _streams(self) -> Streams:
        parts = self._parts
        return Streams(parts.core, parts.topics)
