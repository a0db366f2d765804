"""The asking side of queries: finding the callee, sending again, naming what went wrong."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
from dataclasses import dataclass, field

from tca_bus._bridge import Answer
from tca_bus._choice import Choice
from tca_bus._core import Core
from tca_bus._envelope import Envelope, new_envelope
from tca_bus._errors import (
    AtCapacityError,
    BusGoneError,
    ClosedError,
    NoHandlerError,
    PeerLostError,
    TcaError,
    TimedOutError,
    near_matches,
)
from tca_bus._faults import decode_error
from tca_bus._pool import PoolWait
from tca_bus._presence import PresenceChange, PresentModule
from tca_bus._turns import WithdrawRequest
from tca_bus._wire import Payload, encode_message

logger = logging.getLogger(__name__)

RETRY_DELAY = 0.05
"""Wall seconds before a query is sent again that ended without a reply."""

MOST_EMPTY = 20
"""After so many empty endings in a row from a callee that is there, it counts as lost."""

WITHDRAWAL_TIMEOUT = 2.0
"""Wall seconds in which a module takes back a request that nobody waits for any more."""


@dataclass
class Caller:
    """Sends queries. One query keeps its request id however often it is sent."""

    core: Core
    _choice: Choice = field(default_factory=Choice)

    def begin(self) -> None:
        """Forget modules that are gone."""
        self.core.presence.listen(self._presence_changed)

    async def call(
        self,
        name: str,
        payload: Payload,
        *,
        to: str | PresentModule | None,
        timeout: float,
        withdraw: bool = False,
    ) -> Payload:
        """Ask and give the payload of the answer.

        A query that was under way when the router was lost is sent again when it is back; the
        callee answers a request id once. With ``withdraw`` the callee is told when nobody waits
        for the answer any more.

        Raises:
            NoHandlerError: Nobody handles it, or module ``to`` is not there.
            PeerLostError: The callee died before it answered.
            TimedOutError: No answer within ``timeout`` wall seconds.
            BusGoneError: The router was away for the rest of that time.
            RefusedError: This module may not send it, or it is too big.
            TcaError: What the callee answered, as its own class.
        """
        self.core.permissions.check_sending(self.core.name, name, len(payload.data))
        self.core.tapping.sent(name, payload)
        try:
            async with asyncio.timeout(timeout):
                return await self._call(name, payload, to, withdraw=withdraw)
        except TimeoutError as error:
            if not self.core.session.is_up:
                raise BusGoneError(self.core.session.endpoint, "it was lost") from error
            raise TimedOutError(f"query {name!r}", timeout) from error

    async def ask_callee(
        self,
        callee: PresentModule,
        name: str,
        payload: Payload,
        *,
        envelope: Envelope | None = None,
    ) -> Payload:
        """Ask one module, for as long as it is there, and give the payload of its answer.

        Raises:
            PeerLostError: The callee died before it answered.
            TcaError: What the callee answered, as its own class.
        """
        attachment = (envelope or new_envelope(self.core.incarnation)).model_dump_json().encode()
        self._choice.began(callee.incarnation)
        try:
            answer = await self._ask_until_answered(callee, name, payload, attachment)
        finally:
            self._choice.ended(callee.incarnation)
        if answer.is_error:
            raise decode_error(answer.payload, message=name)
        return answer.payload

    def withdraw(self, callee: PresentModule, name: str, request: str) -> None:
        """Tell a module that nobody waits for the answer to a request any more."""
        telling = self._withdraw(callee, WithdrawRequest(message=name, request=request))
        # A module that is closing is seen to leave, which ends its requests too.
        with contextlib.suppress(ClosedError):
            self.core.spawn(telling, name=f"{self.core.name}.withdraw.{name}")

    async def _call(
        self, name: str, payload: Payload, to: str | PresentModule | None, *, withdraw: bool
    ) -> Payload:
        await self.core.session.connected()
        envelope = new_envelope(self.core.incarnation)
        callee = await self.locate(name, to)
        while True:
            try:
                return await self.ask_callee(callee, name, payload, envelope=envelope)
            except AtCapacityError:
                wait = PoolWait(self, name, envelope.id, lambda: self._candidates(name, to))
                callee = await wait.first()
            except asyncio.CancelledError:
                if withdraw:
                    self.withdraw(callee, name, envelope.id)
                raise

    async def _ask_until_answered(
        self, callee: PresentModule, name: str, payload: Payload, attachment: bytes
    ) -> Answer:
        key = self.core.keys.query(callee, name, self.core.name)
        for _ in range(MOST_EMPTY):
            await self.core.session.connected()
            await self._stays(callee, name)
            answer = await self.core.session.ask(
                key, payload, attachment=attachment, timeout=math.inf
            )
            if answer is not None:
                return answer
            await asyncio.sleep(RETRY_DELAY)
        raise PeerLostError(callee.name, name)

    async def _withdraw(self, callee: PresentModule, order: WithdrawRequest) -> None:
        try:
            async with asyncio.timeout(WITHDRAWAL_TIMEOUT):
                await self.ask_callee(callee, order.wire_name, encode_message(order))
        except (TcaError, TimeoutError) as error:
            logger.debug("request %s is not withdrawn: %s", order.request, error)

    async def locate(self, name: str, to: str | PresentModule | None) -> PresentModule:
        """Choose who is to answer; a suspect is waited for until it is back or lost."""
        if isinstance(to, PresentModule):
            return to
        await self.core.presence.until(lambda: self._is_settled(name, to))
        found = self._choice.choose(self._candidates(name, to))
        if found is None:
            raise self._nobody(name, to)
        return found

    def _is_settled(self, name: str, to: str | None) -> bool:
        """Whether somebody is there for certain, or there is nobody."""
        found = self._candidates(name, to)
        return not found or bool(self.core.presence.table.state_of(found[0].incarnation))

    def _candidates(self, name: str, to: str | PresentModule | None) -> list[PresentModule]:
        """Who may be asked: those that are there for certain, if there is one."""
        table = self.core.presence.table
        if isinstance(to, PresentModule):
            return [to] if table.state_of(to.incarnation) is not False else []
        if to is not None:
            named = table.named(to)
            return [] if named is None else [named]
        found = table.providers(name)
        return [one for one in found if table.state_of(one.incarnation)] or found

    def _nobody(self, name: str, to: str | None) -> NoHandlerError:
        table = self.core.presence.table
        if to is None:
            return NoHandlerError(name, table.known_messages())
        namesakes = near_matches(to, {module.name for module in table.modules()})
        return NoHandlerError(f"{to}:{name}", {f"{module}:{name}" for module in namesakes})

    async def _stays(self, callee: PresentModule, name: str) -> None:
        """Wait until it is known whether the callee is still there."""
        state_of = self.core.presence.table.state_of
        await self.core.presence.until(lambda: state_of(callee.incarnation) is not None)
        if not state_of(callee.incarnation):
            raise PeerLostError(callee.name, name)

    def _presence_changed(self, change: PresenceChange) -> None:
        if not change.appeared:
            self._choice.forget(change.module.incarnation)
