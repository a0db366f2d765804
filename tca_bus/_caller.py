"""The asking side of queries: finding the callee, sending again, naming what went wrong.

A query is *published* to its callee, and the answer is published back: two messages on standing
subscriptions, which Zenoh carries in four fifths of the time of one of its own queries and, with
many under way, three times as often. What that lacks, an end when the callee or a link is gone,
presence tells: a call whose callee vanished and came back is sent again, one whose callee is lost
fails. A callee that is not seen to listen there, or that is silent for a while, is asked by a
Zenoh query, which ends by itself when there is nobody who could answer. However often a query is
sent it keeps its id, and the callee handles an id once.
"""

from __future__ import annotations

import asyncio
import logging
import math
import time

import zenoh
from zenoh.handlers import Callback

from tca_bus._bridge import Answer, Mailbox, attachment_of, payload_of
from tca_bus._core import Core
from tca_bus._envelope import new_stamp
from tca_bus._errors import (
    BusGoneError,
    ClosedError,
    NoHandlerError,
    PeerLostError,
    TcaError,
    TimedOutError,
)
from tca_bus._faults import ERROR_TYPE, decode_error
from tca_bus._keys import parse_sender
from tca_bus._pending import Call, PendingCalls
from tca_bus._presence import PresenceChange, PresentModule
from tca_bus._session import MAILBOX_SIZE
from tca_bus._wire import Payload

logger = logging.getLogger(__name__)

RETRY_DELAY = 0.05
"""Wall seconds before a query is sent again that ended without a reply."""

MOST_EMPTY = 20
"""After so many empty endings in a row from a callee that is there, it counts as lost."""


class Caller:
    """Sends queries. One query keeps its request id however often it is sent."""

    def __init__(self, core: Core) -> None:
        self.core = core
        self._pending = PendingCalls()
        self._loop = asyncio.get_running_loop()
        self._timer: asyncio.TimerHandle | None = None
        self._timer_due = math.inf

    def begin(self) -> None:
        """Listen to answers, and to who is lost or comes back."""
        box = Mailbox[zenoh.Sample](self._take, size=MAILBOX_SIZE)
        self.core.tally.counters["answers"] = lambda: box.dropped
        key = self.core.keys.answers_to(self.core.name, self.core.incarnation)
        self.core.session.zenoh.declare_subscriber(key, Callback(box.post))
        self.core.presence.listen(self._presence_changed)
        self.core.presence.listen_to_returns(self._returned)

    def end(self) -> None:
        """Give up whatever is under way."""
        if self._timer is not None:
            self._timer.cancel()
        for call in self._pending.all():
            call.fail(ClosedError(self.core.name))

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
        call = self._begin_call(name, payload, callee, deadline)
        try:
            answer = await call.answer
        except TimeoutError as error:
            raise self._too_late(name, timeout, self.core.session.can_send) from error
        finally:
            self._pending.remove(call)
            if call.asking is not None:
                call.asking.cancel()
        if answer.is_error:
            raise decode_error(answer.payload, message=name)
        return answer.payload

    def _begin_call(
        self, name: str, payload: Payload, callee: PresentModule, deadline: float
    ) -> Call:
        id, attachment = new_stamp(self.core.incarnation)
        future: asyncio.Future[Answer] = self._loop.create_future()
        call = Call(id, name, callee, payload, attachment, deadline, future)
        self._pending.add(call, time.monotonic())
        try:
            if not self._publish(call):
                self._ask(call)
        except BaseException:
            self._pending.remove(call)
            raise
        self._set_timer(call.due)
        return call

    def _publish(self, call: Call) -> bool:
        """Send a query to where its callee listens; False when nobody is seen to."""
        key = self.core.keys.call(call.callee, call.name, self.core.name)
        outlet = self.core.outlets.at(key)
        if not outlet.is_heard:
            return False
        outlet.put(call.payload, call.attachment)
        return True

    def _take(self, sample: zenoh.Sample) -> None:
        id = (attachment_of(sample) or b"").decode(errors="replace")
        call = self._pending.find(id, parse_sender(str(sample.key_expr)))
        if call is not None:
            payload = payload_of(sample)
            call.settle(Answer(payload, is_error=payload.encoding == ERROR_TYPE))

    def _presence_changed(self, change: PresenceChange) -> None:
        if change.appeared:
            return
        for call in self._pending.to(change.module.incarnation):
            call.fail(PeerLostError(call.callee.name, call.name))
            self.core.outlets.forget(self.core.keys.call(call.callee, call.name, self.core.name))

    def _returned(self, module: PresentModule) -> None:
        """Send again what may have been lost with the link to a module, or its answer."""
        for call in self._pending.to(module.incarnation):
            if call.asking is None and not self._publish(call):
                self._ask(call)

    def _set_timer(self, due: float) -> None:
        if due >= self._timer_due:
            return
        if self._timer is not None:
            self._timer.cancel()
        self._timer_due = due
        self._timer = self._loop.call_later(max(0.0, due - time.monotonic()), self._look_at_due)

    def _look_at_due(self) -> None:
        self._timer, self._timer_due = None, math.inf
        now = time.monotonic()
        for call in self._pending.take_due(now):
            if call.deadline <= now:
                call.fail(TimeoutError())
            elif call.asking is None:
                self._ask(call)
        self._set_timer(self._pending.next_due())

    def _ask(self, call: Call) -> None:
        name = f"{self.core.name}.ask.{call.name}"
        call.asking = self.core.spawn(self._ask_until_answered(call), name=name)

    async def _ask_until_answered(self, call: Call) -> None:
        """Send a Zenoh query, again for as long as its end says nothing about the callee."""
        try:
            call.settle(await self._answer_to(call))
        except TimeoutError:
            # Not yet: what is due at the deadline says so.
            logger.debug("query %r to %s ran out of time", call.name, call.callee.name)
        except Exception as error:
            # Whatever it is, it is the caller's.
            call.fail(error)

    async def _answer_to(self, call: Call) -> Answer:
        key = self.core.keys.query(call.callee, call.name, self.core.name)
        for _ in range(MOST_EMPTY):
            await self.core.session.sendable()
            await self._stays(call.callee, call.name)
            left = max(call.deadline - time.monotonic(), 0.001)
            answer = await self.core.session.ask(
                key, call.payload, attachment=call.attachment, timeout=left
            )
            if answer is not None:
                return answer
            await asyncio.sleep(RETRY_DELAY)
        raise PeerLostError(call.callee.name, call.name)

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
                await self._stays(callee, name)
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

    async def _stays(self, callee: PresentModule, name: str) -> None:
        """Wait until it is known whether the callee is still there."""
        state_of = self.core.presence.table.state_of
        await self.core.presence.until(lambda: state_of(callee.incarnation) is not None)
        if not state_of(callee.incarnation):
            raise PeerLostError(callee.name, name)
