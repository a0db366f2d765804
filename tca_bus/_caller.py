"""The asking side of queries: finding the callee, naming what went wrong."""

from __future__ import annotations

import asyncio
import time

from tca_bus._asking import Asking
from tca_bus._core import Core
from tca_bus._envelope import new_stamp
from tca_bus._errors import BusGoneError, NoHandlerError, TcaError, TimedOutError
from tca_bus._faults import decode_error
from tca_bus._presence import PresentModule
from tca_bus._wire import Payload


class Caller:
    """Sends queries. One query keeps its request id however often it is sent."""

    def __init__(self, core: Core) -> None:
        self.core = core
        self._asking = Asking(core)

    def begin(self) -> None:
        """Be ready to take answers."""
        self._asking.begin()

    def end(self) -> None:
        """Give up whatever is under way."""
        self._asking.end()

    async def call(
        self, name: str, payload: Payload, *, to: str | PresentModule | None, timeout: float
    ) -> Payload:
        """Ask and give the payload of the answer.

        A query that was under way when the router was lost is sent again when it is back; the
        callee answers a request id once.

        Raises:
            NoHandlerError: Nobody handles it, or module ``to`` is not there.
            PeerLostError: The callee died before it answered.
            TimedOutError: No answer within ``timeout`` wall seconds.
            BusGoneError: The router was away for the rest of that time.
            TcaError: What the callee answered, as its own class.
        """
        deadline = time.monotonic() + timeout
        callee = self._at_hand(name, to)
        if callee is None:
            callee = await self._look_for(name, to, timeout)
        stamp = new_stamp(self.core.incarnation)
        try:
            answer = await self._asking.ask(callee, name, payload, stamp=stamp, deadline=deadline)
        except TimeoutError as error:
            raise self._too_late(name, timeout, self.core.session.can_send) from error
        if answer.is_error:
            raise decode_error(answer.payload, message=name)
        return answer.payload

    def _too_late(self, name: str, timeout: float, is_reachable: bool) -> TcaError:
        if not is_reachable:
            return BusGoneError(self.core.session.endpoint, "it was lost")
        return TimedOutError(f"query {name!r}", timeout)

    def _at_hand(self, name: str, to: str | PresentModule | None) -> PresentModule | None:
        """The callee, if it is there for certain and can be reached now."""
        if not self.core.session.can_send:
            return None
        found = to if isinstance(to, PresentModule) else self._candidate(name, to)
        if found is None or not self.core.presence.table.state_of(found.incarnation):
            return None
        return found

    async def _look_for(
        self, name: str, to: str | PresentModule | None, timeout: float
    ) -> PresentModule:
        """Find the callee when the router is back and it is known who has come back with it."""
        try:
            async with asyncio.timeout(timeout):
                await self.core.session.sendable()
                callee = await self.locate(name, to)
                await self._asking.stays(callee, name)
        except TimeoutError as error:
            raise self._too_late(name, timeout, self.core.session.is_up) from error
        return callee

    async def locate(self, name: str, to: str | PresentModule | None) -> PresentModule:
        """Find who is to answer; a suspect is waited for until it is back or lost."""
        if isinstance(to, PresentModule):
            return to
        await self.core.presence.until(lambda: self._is_settled(name, to))
        found = self._candidate(name, to)
        if found is None:
            raise self._nobody(name, to)
        return found

    def _is_settled(self, name: str, to: str | None) -> bool:
        """Whether the best candidate is there for certain, or there is none."""
        found = self._candidate(name, to)
        return found is None or bool(self.core.presence.table.state_of(found.incarnation))

    def _candidate(self, name: str, to: str | None) -> PresentModule | None:
        table = self.core.presence.table
        if to is not None:
            return table.named(to)
        return next(iter(table.providers(name)), None)

    def _nobody(self, name: str, to: str | None) -> NoHandlerError:
        table = self.core.presence.table
        if to is None:
            return NoHandlerError(name, table.known_messages())
        return NoHandlerError(f"{to}:{name}", {f"{m.name}:{name}" for m in table.modules()})
