"""Taps on what goes straight from module to module: queries, informs and broadcasts.

Whoever taps says so in its liveliness token, so that every module knows without being asked. The
module that handles a tapped message tells it, and for ``BeforeHandling`` waits for its answer;
the one that sends it tells of ``WhenSent``. Messages of the bus itself are not tapped.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from tca_bus._attachments import ANY, TapCondition, TapNotice
from tca_bus._context import Context
from tca_bus._errors import RefusedError, TcaError
from tca_bus._faults import failure_of
from tca_bus._handlers import Handler
from tca_bus._messages import Message, Query
from tca_bus._presence import PresentModule, TapWord
from tca_bus._rights import BUS_PREFIX, Right
from tca_bus._wire import Payload, decode_plain, encode_message

if TYPE_CHECKING:
    from tca_bus._core import Core

logger = logging.getLogger(__name__)

PATIENCE = 30.0
"""Wall seconds that a blocking tap may hold a message; then it goes on, or fails."""

Action = Callable[[TapNotice], Awaitable[None]]
"""What a tap does when it fires; if it raises, a blocking tap has not let the message pass."""


class TellTap(Query[None]):
    """To a module that taps a message: it has come to one of the tap's conditions."""

    wire_name = "tca.tapped"

    notice: TapNotice


class Ask(Protocol):
    """Sends a query; see `Caller.call`."""

    async def __call__(
        self, name: str, payload: Payload, *, to: str | PresentModule | None, timeout: float
    ) -> Payload:
        """Send it and give the answer."""
        ...


@dataclass
class Tapping:
    """The taps of one module on others' messages, and those of others on its own."""

    _mine: dict[str, tuple[TapWord, Action]] = field(default_factory=dict)
    _index: dict[str, list[tuple[PresentModule, TapWord]]] | None = None
    _core: Core | None = None
    _ask: Ask | None = None

    def begin(self, core: Core, ask: Ask) -> None:
        """Follow who taps what."""
        self._core, self._ask = core, ask
        core.presence.listen(lambda _: self._forget())

    def add(self, id: str, word: TapWord, action: Action) -> None:
        """Tap a message; the module's token has to be declared again."""
        self._mine[id] = (word, action)

    def remove(self, id: str) -> bool:
        """End a tap; gives whether it was there. The token has to be declared again."""
        return self._mine.pop(id, None) is not None

    def words(self) -> tuple[TapWord, ...]:
        """The taps of this module, as its token names them."""
        return tuple(sorted({word for word, _ in self._mine.values()}))

    async def told(self, told: TellTap, context: Context) -> None:
        """A message that this module taps has come to a condition.

        Raises:
            RefusedError: The module that says so has no part in the message.
        """
        notice = told.notice
        self._check_teller(notice, context.sender)
        for word, action in list(self._mine.values()):
            if word.condition == notice.condition and word.message in {ANY, notice.message}:
                await action(notice)

    def _check_teller(self, notice: TapNotice, teller: str) -> None:
        """Believe of a sending only who sent it, of the rest only who handles the message."""
        if self._core is None or notice.condition is TapCondition.WHEN_SENT:
            is_believed, who = teller == notice.sender, "its sender"
        elif providers := self._core.presence.table.providers(notice.message):
            is_believed, who = teller in {one.name for one in providers}, "who handles it"
        else:
            # Nobody provides a broadcast: those hear it who may.
            permissions, owner = self._core.permissions, notice.sender
            is_believed = permissions.may(teller, Right.LISTEN, notice.message, owner=owner)
            who = "who may listen to it"
        if not is_believed:
            what = f"the word of {teller!r} that {notice.message!r} came to {notice.condition}"
            raise RefusedError(what, f"a tap goes only by {who}")

    def sent(self, name: str, payload: Payload) -> None:
        """Tell of a message that this module sends."""
        if self._core is None or not self.is_tapped(name):
            return
        notice = TapNotice(
            condition=TapCondition.WHEN_SENT,
            message=name,
            data=_data_of(payload, name),
            sender=self._core.name,
        )
        self._tell(notice)

    def is_tapped(self, name: str) -> bool:
        """Whether anybody taps a message."""
        # As a rule nobody taps anything.
        return self._index != {} and bool(self._taps(name))

    async def call(self, handler: Handler, message: Message, context: Context) -> Any:
        """Run a handler, telling those who tap its message.

        Raises:
            RefusedError: A blocking tap that is to fail did not let it pass.
        """
        if not self.is_tapped(handler.name):
            return await handler.call(message, context)
        notice = TapNotice(
            condition=TapCondition.BEFORE_HANDLING,
            message=handler.name,
            data=message.model_dump(mode="json"),
            sender=context.sender,
        )
        await self._hold(notice)
        self._tell(_at(notice, TapCondition.WHILE_HANDLING))
        try:
            value = await handler.call(message, context)
        except Exception as error:
            failure = failure_of(error, message=handler.name, module=context.module.name)
            facts = {"failure": failure.model_dump(mode="json")}
            self._tell(_at(notice, TapCondition.AFTER_HANDLED, **facts))
            raise
        reply = value.model_dump(mode="json") if hasattr(value, "model_dump") else value
        self._tell(_at(notice, TapCondition.AFTER_HANDLED))
        self._tell(_at(notice, TapCondition.AFTER_REPLIED, reply=reply))
        return value

    def _taps(self, name: str) -> list[tuple[PresentModule, TapWord]]:
        if self._core is None or name.startswith(BUS_PREFIX):
            return []
        if self._index is None:
            self._index = {}
            for module in self._core.presence.table.modules():
                for word in module.taps:
                    self._index.setdefault(word.message, []).append((module, word))
        if not self._index:
            return []
        return [*self._index.get(name, ()), *self._index.get(ANY, ())]

    def _forget(self) -> None:
        self._index = None

    def _tell(self, notice: TapNotice) -> None:
        """Tell those whose taps hold nothing, in the background."""
        for module, word in self._taps(notice.message):
            if word.condition == notice.condition and self._core is not None:
                name = f"{self._core.name}.tap.{module.name}"
                self._core.spawn(self._tell_one(module, notice), name=name)

    async def _tell_one(self, module: PresentModule, notice: TapNotice) -> None:
        try:
            await self._send(module, notice)
        except TcaError as error:
            logger.warning("the tap of module %s was not told: %s", module.name, error)

    async def _hold(self, notice: TapNotice) -> None:
        """Wait until all blocking taps let the message pass."""
        holding = [
            self._hold_one(module, word, notice)
            for module, word in self._taps(notice.message)
            if word.condition == notice.condition
        ]
        for outcome in await asyncio.gather(*holding, return_exceptions=True):
            if isinstance(outcome, BaseException):
                raise outcome

    async def _hold_one(self, module: PresentModule, word: TapWord, notice: TapNotice) -> None:
        try:
            await self._send(module, notice)
        except TcaError as error:
            if word.fails:
                why = f"the tap of module {module.name!r} did not let it pass: {error}"
                raise RefusedError(f"message {notice.message!r}", why) from error
            logger.warning("the tap of module %s let go: %s", module.name, error)

    async def _send(self, module: PresentModule, notice: TapNotice) -> None:
        if self._ask is not None:
            payload = encode_message(TellTap(notice=notice))
            await self._ask(TellTap.wire_name, payload, to=module, timeout=PATIENCE)


def _at(notice: TapNotice, condition: TapCondition, **facts: Any) -> TapNotice:
    return notice.model_copy(update={"condition": condition, **facts})


def _data_of(payload: Payload, name: str) -> dict[str, Any]:
    plain = decode_plain(payload, name)
    return plain if isinstance(plain, dict) else {}
