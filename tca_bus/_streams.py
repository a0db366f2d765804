"""What a module can listen to, as subscriptions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from tca_bus._core import Core
from tca_bus._errors import ConfigError
from tca_bus._handlers import ONE_WAY
from tca_bus._messages import Message
from tca_bus._presence import PresenceChange
from tca_bus._protocol import TaskStatus
from tca_bus._rights import Right
from tca_bus._subscription import Subscription
from tca_bus._tasks import STATUS_ENCODING, decode_status
from tca_bus._topics import Arrival, Topics
from tca_bus._wire import Payload

M = TypeVar("M", bound=Message)

PRESENCE_QUEUE = 4096


@dataclass(frozen=True)
class Streams:
    """Makes the subscriptions of one open module."""

    core: Core
    topics: Topics

    def messages(self, message_type: type[M], *, size: int) -> Subscription[M]:
        """Listen to a broadcast or inform type."""
        if message_type.message_class not in ONE_WAY:
            kind = message_type.message_class.value
            raise ConfigError("subscription", kind, "a Broadcast or Inform type")

        async def connect(subscription: Subscription[M]) -> Callable[[], None]:
            def push(arrival: Arrival[Any]) -> None:
                subscription.push(arrival.value)

            end = self.topics.listen_to(message_type, push)
            return await self._connected(subscription, end)

        return Subscription(message_type.wire_name, connect, size=size)

    def statuses(self, sender: str, *, size: int) -> Subscription[TaskStatus]:
        """Listen to the task states of a sender; ``*`` for all."""

        async def connect(subscription: Subscription[TaskStatus]) -> Callable[[], None]:
            def push(arrival: Arrival[TaskStatus]) -> None:
                subscription.push(arrival.value)

            self.core.permissions.check(self.core.name, Right.WATCH, sender)
            end = self.topics.listen(self.core.keys.task(sender, "*"), decode_status, push)
            return await self._connected(subscription, end)

        return Subscription("task states", connect, size=size)

    def modules(self) -> Subscription[PresenceChange]:
        """Listen to the comings and losses of modules, beginning with those that are there."""

        async def connect(subscription: Subscription[PresenceChange]) -> Callable[[], None]:
            for module in self.core.presence.table.modules():
                subscription.push(PresenceChange(module, appeared=True))
            return self.core.presence.listen(subscription.push)

        return Subscription("presence", connect, size=PRESENCE_QUEUE)

    def publish_status(self, status: TaskStatus) -> None:
        """Publish a task's state on the key of its sender."""
        payload = Payload(status.model_dump_json().encode(), STATUS_ENCODING)
        self.topics.send(self.core.keys.task(status.sender, status.id), payload)

    async def _connected(
        self, subscription: Subscription[Any], end: Callable[[], None]
    ) -> Callable[[], None]:
        """Wait until the router knows, so that nothing sent from here on is missed."""
        counters = self.core.tally.counters
        name = f"subscription to {subscription.name} {id(subscription):x}"
        counters[name] = lambda: subscription.dropped

        def disconnect() -> None:
            counters.pop(name, None)
            end()

        try:
            await self.core.session.settle(self.core.keys.all_presence())
        except BaseException:
            disconnect()
            raise
        return disconnect
