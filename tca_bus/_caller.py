"""The asking side of queries: finding the callee, naming what went wrong."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
import time
from typing import NamedTuple

from tca_bus._asking import Asking
from tca_bus._choice import Choice
from tca_bus._core import Core
from tca_bus._envelope import Stamp, new_stamp
from tca_bus._errors import (
    AtCapacityError,
    BusGoneError,
    ClosedError,
    NoHandlerError,
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

WITHDRAWAL_TIMEOUT = 2.0
"""Wall seconds in which a module takes back a request that nobody waits for any more."""


class _Request(NamedTuple):
    name: str
    payload: Payload
    stamp: Stamp
    withdraw: bool


class Caller:
    """Sends queries. One query keeps its request id however often it is sent."""

    def __init__(self, core: Core) -> None:
        self.core = core
        self._asking = Asking(core)
        self._choice = Choice()

    def begin(self) -> None:
        """Be ready to take answers, and forget modules that are gone."""
        self._asking.begin()
        self.core.presence.listen(self._presence_changed)

    def end(self) -> None:
        """Give up whatever is under way."""
        self._asking.end()

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
        request = _Request(name, payload, new_stamp(self.core.incarnation), withdraw)
        deadline = time.monotonic() + timeout
        callee = self._at_hand(name, to)
        try:
            if callee is not None:
                try:
                    return await self._ask(callee, request, deadline)
                except AtCapacityError as error:
                    logger.debug("%s", error)
            async with asyncio.timeout(deadline - time.monotonic()):
                return await self._look_and_ask(request, to, is_full=callee is not None)
        except TimeoutError as error:
            if not self._could_reach(callee):
                raise BusGoneError(self.core.session.endpoint, "it was lost") from error
            raise TimedOutError(f"query {name!r}", timeout) from error

    def _could_reach(self, callee: PresentModule | None) -> bool:
        """Whether the router is there, or a callee that is known to be there without it."""
        session, table = self.core.session, self.core.presence.table
        if session.is_up or callee is None:
            return session.is_up
        return session.can_send and table.state_of(callee.incarnation) is True

    async def ask_callee(self, callee: PresentModule, name: str, payload: Payload) -> Payload:
        """Ask one module, for as long as it is there, and give the payload of its answer.

        Raises:
            PeerLostError: The callee died before it answered.
            TcaError: What the callee answered, as its own class.
        """
        request = _Request(name, payload, new_stamp(self.core.incarnation), withdraw=False)
        return await self._ask(callee, request, math.inf)

    def withdraw(self, callee: PresentModule, name: str, request: str) -> None:
        """Tell a module that nobody waits for the answer to a request any more."""
        telling = self._withdraw(callee, WithdrawRequest(message=name, request=request))
        # A module that is closing is seen to leave, which ends its requests too.
        with contextlib.suppress(ClosedError):
            self.core.spawn(telling, name=f"{self.core.name}.withdraw.{name}")

    async def _look_and_ask(
        self, request: _Request, to: str | PresentModule | None, *, is_full: bool
    ) -> Payload:
        """Ask when it is known who is there, and again while all of them are full."""
        name = request.name
        await self.core.session.sendable()
        callee = None if is_full else await self.locate(name, to)
        while True:
            if callee is None:
                wait = PoolWait(self, name, request.stamp.id, lambda: self._candidates(name, to))
                callee = await wait.first()
            try:
                return await self._ask(callee, request, math.inf)
            except AtCapacityError:
                callee = None

    async def _ask(self, callee: PresentModule, request: _Request, deadline: float) -> Payload:
        self._choice.began(callee.incarnation)
        try:
            answer = await self._asking.ask(
                callee, request.name, request.payload, stamp=request.stamp, deadline=deadline
            )
        except (asyncio.CancelledError, TimeoutError):
            if request.withdraw:
                self.withdraw(callee, request.name, request.stamp.id)
            raise
        finally:
            self._choice.ended(callee.incarnation)
        if answer.is_error:
            raise decode_error(answer.payload, message=request.name)
        return answer.payload

    def _at_hand(self, name: str, to: str | PresentModule | None) -> PresentModule | None:
        """Who is to answer, if somebody is there for certain and can be reached now."""
        if not self.core.session.can_send:
            return None
        table = self.core.presence.table
        found = table.providers(name) if to is None else self._candidates(name, to)
        if len(found) > 1:
            found = [one for one in found if table.state_of(one.incarnation)]
        if len(found) != 1:
            return self._choice.choose(found)
        return found[0] if table.state_of(found[0].incarnation) else None

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

    def _presence_changed(self, change: PresenceChange) -> None:
        if not change.appeared:
            self._choice.forget(change.module.incarnation)
