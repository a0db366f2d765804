"""Informs and broadcasts: publishing, and one Zenoh subscriber per message that is listened to."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from typing import Any, Generic, NamedTuple, TypeVar

import zenoh

from tca_bus._bridge import attachment_of, payload_of
from tca_bus._context import Context
from tca_bus._core import Core
from tca_bus._envelope import Envelope, begin_handling, new_stamp, read_envelope
from tca_bus._errors import InvalidMessageError
from tca_bus._handlers import Handler, Handlers
from tca_bus._keys import parse_sender
from tca_bus._messages import Message, MessageClass
from tca_bus._outlets import Outlets
from tca_bus._serving import ContextFactory
from tca_bus._subscription import Subscription
from tca_bus._wire import Payload, decode_messages

T = TypeVar("T")


class Arrival(NamedTuple, Generic[T]):
    """A decoded message with where it came from."""

    value: T
    sender: str
    envelope: Envelope


Sink = Callable[[Arrival[Any]], None]
Decode = Callable[[Payload], Sequence[Any]]
"""Gives the messages in a payload: one, or many that were sent together."""


class Topic:
    """One Zenoh subscriber, decoded once and handed to all who listen."""

    def __init__(self, core: Core, key: str, decode: Decode) -> None:
        self._core = core
        self._key = key
        self._decode = decode
        self.sinks: tuple[Sink, ...] = ()
        box, post = core.session.mailbox(self._take)
        core.tally.counters[key] = lambda: box.dropped
        self._subscriber = core.session.declare_subscriber(key, post)

    def _take(self, sample: zenoh.Sample) -> int:
        sender = parse_sender(str(sample.key_expr))
        try:
            envelope = read_envelope(attachment_of(sample))
            values = self._decode(payload_of(sample))
        except InvalidMessageError as error:
            self._core.tally.note_invalid(error, sender=sender)
            return 1
        for value in values:
            arrival = Arrival(value, sender, envelope)
            for sink in self.sinks:
                sink(arrival)
        return len(values)

    def end(self) -> None:
        """Undeclare the subscriber."""
        self._core.tally.counters.pop(self._key, None)
        self._core.session.undeclare(self._subscriber)


class Topics:
    """The one-way messages of a module."""

    def __init__(self, core: Core, context: ContextFactory) -> None:
        self._core = core
        self._context = context
        self._topics: dict[str, Topic] = {}
        self._broadcasts = Outlets(core.session, block=False)
        self._lost = 0
        core.tally.counters["sent while the router was away"] = lambda: self._lost

    def publish(self, kind: MessageClass, name: str, payload: Payload) -> None:
        """Send to all who listen; a broadcast while the router is away is lost and counted."""
        core = self._core
        core.permissions.check_sending(core.name, name, len(payload.data))
        core.tapping.sent(name, payload)
        if not core.session.can_send:
            self._lost += 1
            return
        if kind is MessageClass.INFORM:
            outlet = core.outlets.at(core.keys.one_way("inform", name, core.name))
        else:
            outlet = self._broadcasts.at(core.keys.one_way("broadcast", name, core.name))
        outlet.put(payload, new_stamp(core.incarnation).attachment)

    def send(self, key: str, payload: Payload) -> None:
        """Send on a key that is used once or twice; not dropped when the link is congested."""
        if not self._core.session.can_send:
            self._lost += 1
            return
        attachment = new_stamp(self._core.incarnation).attachment
        self._core.session.put(key, payload, attachment=attachment, block=True)

    def listen(self, key: str, decode: Decode, sink: Sink) -> Callable[[], None]:
        """Hand everything on ``key`` to ``sink``; gives a function that ends it."""
        topic = self._topics.get(key)
        if topic is None:
            topic = self._topics[key] = Topic(self._core, key, decode)
        topic.sinks = (*topic.sinks, sink)

        def end() -> None:
            kept = list(topic.sinks)
            kept.remove(sink)
            topic.sinks = tuple(kept)
            if not topic.sinks:
                del self._topics[key]
                topic.end()

        return end

    def listen_to(self, message_type: type[Message], sink: Sink) -> Callable[[], None]:
        """Hand all messages of a type to ``sink``."""
        kind, name = message_type.message_class, message_type.wire_name
        is_inform = kind == MessageClass.INFORM
        self._core.permissions.check_listening(self._core.name, name, is_inform=is_inform)
        key = self._core.keys.one_way(kind.value, name, "*")
        return self.listen(key, lambda payload: decode_messages(payload, message_type), sink)

    async def handle(
        self, handler: Handler, handlers: Handlers, arrivals: Subscription[Arrival[Any]]
    ) -> None:
        """Run a handler for each message in turn; one that fails is logged and left behind."""
        async for first in arrivals:
            arrival: Arrival[Any] | None = first
            while arrival is not None:
                begin_handling(arrival.envelope)
                context = self._context(sender=arrival.sender, id=arrival.envelope.id)
                try:
                    if handler.resource is None:
                        await self._run(handler, arrival.value, context)
                    else:
                        async with handlers.place(handler):
                            await self._run(handler, arrival.value, context)
                except Exception as error:
                    self._complain(error, handler, arrival.sender)
                arrival = arrivals.at_hand()

    def _run(self, handler: Handler, message: Message, context: Context) -> Awaitable[Any]:
        tapping = self._core.tapping
        if tapping.is_tapped(handler.name):
            return tapping.call(handler, message, context)
        return handler.call(message, context)

    def _complain(self, error: Exception, handler: Handler, sender: str) -> None:
        name = handler.message_type.wire_name
        cause = f"handler of {name}: {type(error).__name__}"
        self._core.tally.complain(cause, f"handler of {name} from {sender} failed", error=error)
