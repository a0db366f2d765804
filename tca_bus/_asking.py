"""Asking one module: how a question gets there and its answer back, whatever happens meanwhile.

A question is *published* to its callee, and the answer is published back: two messages on
standing subscriptions, which Zenoh carries in four fifths of the time of one of its own queries
and, with many under way, three times as often. What that lacks, an end when the callee or a link
is gone, presence tells: a call whose callee vanished and came back is sent again, one whose callee
is lost fails. A callee that is not seen to listen there, or that is silent for a while, is asked
by a Zenoh query, which ends by itself when there is nobody who could answer. However often a
question is sent it keeps its id, and the callee handles an id once.
"""

from __future__ import annotations

import asyncio
import logging
import math
import time

import zenoh

from tca_bus._bridge import Answer, attachment_of, payload_of
from tca_bus._core import Core
from tca_bus._envelope import Stamp
from tca_bus._errors import ClosedError, PeerLostError
from tca_bus._faults import ERROR_TYPE
from tca_bus._keys import parse_sender
from tca_bus._pending import Call, PendingCalls
from tca_bus._presence import PresenceChange, PresentModule
from tca_bus._wire import Payload

logger = logging.getLogger(__name__)

RETRY_DELAY = 0.05
"""Wall seconds before a query is sent again that ended without a reply."""

MOST_EMPTY = 20
"""After so many empty endings in a row from a callee that is there, it counts as lost."""


class Asking:
    """The questions under way from one module."""

    def __init__(self, core: Core) -> None:
        self._core = core
        self._pending = PendingCalls()
        self._loop = asyncio.get_running_loop()
        self._timer: asyncio.TimerHandle | None = None
        self._timer_due = math.inf

    def begin(self) -> None:
        """Listen to answers, and to who is lost or comes back."""
        core = self._core
        box, post = core.session.mailbox(self._take)
        core.tally.counters["answers"] = lambda: box.dropped
        key = core.keys.answers_to(core.name, core.incarnation)
        core.session.declare_subscriber(key, post)
        core.presence.listen(self._presence_changed)
        core.presence.listen_to_returns(self._returned)

    def end(self) -> None:
        """Give up whatever is under way."""
        if self._timer is not None:
            self._timer.cancel()
        for call in self._pending.all():
            call.fail(ClosedError(self._core.name))

    async def ask(
        self,
        callee: PresentModule,
        name: str,
        payload: Payload,
        *,
        stamp: Stamp,
        deadline: float = math.inf,
    ) -> Answer:
        """Ask until there is an answer; ``deadline`` is a time of `time.monotonic`.

        Raises:
            PeerLostError: The callee died before it answered.
            ClosedError: This module was closed.
            TimeoutError: There was no answer by the deadline.
        """
        if not self._core.presence.table.state_of(callee.incarnation):
            await self.stays(callee, name)
        future: asyncio.Future[Answer] = self._loop.create_future()
        call = Call(stamp.id, name, callee, payload, stamp.attachment, deadline, future)
        self._pending.add(call, time.monotonic())
        try:
            if not self._publish(call):
                self._ask_slowly(call)
            self._set_timer(call.due)
            return await future
        finally:
            self._pending.remove(call)
            if call.asking is not None:
                call.asking.cancel()

    def _publish(self, call: Call) -> bool:
        """Send a query to where its callee listens; False when nobody is seen to now."""
        if not self._core.session.can_send:
            return False
        key = self._core.keys.call(call.callee, call.name, self._core.name)
        outlet = self._core.outlets.at(key)
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
        self._core.outlets.forget_module(change.module.incarnation)

    def _returned(self, module: PresentModule) -> None:
        """Send again what may have been lost with the link to a module, or its answer."""
        for call in self._pending.to(module.incarnation):
            if call.asking is None and not self._publish(call):
                self._ask_slowly(call)

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
                self._ask_slowly(call)
        self._set_timer(self._pending.next_due())

    def _ask_slowly(self, call: Call) -> None:
        name = f"{self._core.name}.ask.{call.name}"
        call.asking = self._core.spawn(self._ask_until_answered(call), name=name)

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
        key = self._core.keys.query(call.callee, call.name, self._core.name)
        for _ in range(MOST_EMPTY):
            await self._core.session.sendable()
            await self.stays(call.callee, call.name)
            left = max(call.deadline - time.monotonic(), 0.001)
            answer = await self._core.session.ask(
                key, call.payload, attachment=call.attachment, timeout=left
            )
            if answer is not None:
                return answer
            await asyncio.sleep(RETRY_DELAY)
        raise PeerLostError(call.callee.name, call.name)

    async def stays(self, callee: PresentModule, name: str) -> None:
        """Wait until it is known that the callee is still there.

        Raises:
            PeerLostError: It is not.
        """
        state_of = self._core.presence.table.state_of
        await self._core.presence.until(lambda: state_of(callee.incarnation) is not None)
        if not state_of(callee.incarnation):
            raise PeerLostError(callee.name, name)
