"""The asking side of queries: finding the callee, sending again, naming what went wrong."""

from __future__ import annotations

import asyncio
import time
from dataclasses import dataclass

from tca_bus._bridge import Answer
from tca_bus._core import Core
from tca_bus._envelope import new_envelope
from tca_bus._errors import BusGoneError, NoHandlerError, PeerLostError, TimedOutError
from tca_bus._faults import decode_error
from tca_bus._presence import PresentModule
from tca_bus._wire import Payload

RETRY_DELAY = 0.05
"""Wall seconds before a query is sent again that ended without a reply."""

MOST_EMPTY = 20
"""After so many empty endings in a row from a callee that is there, it counts as lost."""


@dataclass
class Caller:
    """Sends queries. One query keeps its request id however often it is sent."""

    core: Core

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
        try:
            async with asyncio.timeout(timeout):
                answer = await self._call(name, payload, to, timeout)
        except TimeoutError as error:
            if not self.core.session.is_up:
                raise BusGoneError(self.core.session.endpoint, "it was lost") from error
            raise TimedOutError(f"query {name!r}", timeout) from error
        if answer.is_error:
            raise decode_error(answer.payload, message=name)
        return answer.payload

    async def _call(
        self, name: str, payload: Payload, to: str | PresentModule | None, timeout: float
    ) -> Answer:
        deadline = time.monotonic() + timeout
        await self.core.session.connected()
        callee = await self.locate(name, to)
        key = self.core.keys.query(callee, name, self.core.name)
        attachment = new_envelope(self.core.incarnation).model_dump_json().encode()
        for _ in range(MOST_EMPTY):
            await self.core.session.connected()
            await self._stays(callee, name)
            left = max(deadline - time.monotonic(), 0.001)
            answer = await self.core.session.ask(key, payload, attachment=attachment, timeout=left)
            if answer is not None:
                return answer
            await asyncio.sleep(RETRY_DELAY)
        raise PeerLostError(callee.name, name)

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

    async def _stays(self, callee: PresentModule, name: str) -> None:
        """Wait until it is known whether the callee is still there."""
        state_of = self.core.presence.table.state_of
        await self.core.presence.until(lambda: state_of(callee.incarnation) is not None)
        if not state_of(callee.incarnation):
            raise PeerLostError(callee.name, name)
