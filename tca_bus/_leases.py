"""The holds of one module: asking central for them and following what becomes of them."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import uuid
from dataclasses import dataclass, field

from tca_bus._core import Core
from tca_bus._errors import ClosedError, LeaseLostError, RefusedError, TcaError, TimedOutError
from tca_bus._handle import REFRESH_PERIOD
from tca_bus._lease import Acquisition, Lease
from tca_bus._presence import PresenceChange
from tca_bus._resource_messages import (
    AcquireResources,
    CheckHolds,
    HoldChanged,
    HoldKind,
    ReleaseResources,
)
from tca_bus._tasks import CENTRAL, OUT_OF_REACH, TRY_TIMEOUT, TaskSender
from tca_bus._topics import Arrival, Topics
from tca_bus._wire import build

logger = logging.getLogger(__name__)

ACKNOWLEDGE_TIMEOUT = 10.0
"""Wall seconds in which central has to say that it knows of a hold."""

RELEASE_PATIENCE = 2.0
"""Wall seconds for which giving back waits for central's word; after that it goes on by itself."""


@dataclass
class Leases:
    """Keeps the holds of a module up to date for as long as it has any."""

    core: Core
    sender: TaskSender
    topics: Topics
    _leases: dict[str, Lease] = field(default_factory=dict)
    _bell: asyncio.Event = field(default_factory=asyncio.Event)
    _keeping: asyncio.Task[None] | None = None
    _is_listening: bool = False

    def acquisition(
        self,
        kind: HoldKind,
        names: tuple[str, ...],
        *,
        priority: int,
        timeout: float | None,
        task: str | None,
        attempt: int,
    ) -> Acquisition:
        """A hold that is asked for when it is awaited or entered.

        Raises:
            InvalidMessageError: A name cannot be that of a resource.
        """
        request = build(
            AcquireResources,
            id=f"{self.core.name}-{uuid.uuid4().hex[:20]}",
            kind=kind,
            names=names,
            incarnation=self.core.incarnation,
            task=task,
            attempt=attempt,
            priority=priority,
        )
        return Acquisition(lambda: self._take(request, timeout))

    def held_here(self) -> tuple[str, ...]:
        """The ids of what the running asyncio task has taken and holds."""
        current = asyncio.current_task()
        return tuple(
            lease.id for lease in self._leases.values() if lease.is_held and lease.owner is current
        )

    def ask_again(self) -> None:
        """The router is back: what was told meanwhile is lost."""
        self._bell.set()

    async def let_go(self, lease: Lease) -> None:
        """Have central end a hold; waits a while for its word."""
        self._leases.pop(lease.id, None)
        with contextlib.suppress(ClosedError):
            releasing = self.core.spawn(self._release(lease.id), name=f"release.{lease.id}")
            await asyncio.wait({releasing}, timeout=RELEASE_PATIENCE)

    async def _take(self, request: AcquireResources, timeout: float | None) -> Lease:
        inside = request.model_copy(update={"holding": self.held_here()})
        lease = Lease(inside, self)
        self._begin_to_follow(lease)
        try:
            async with asyncio.timeout(timeout):
                await self._ask(lease)
                await lease.settled()
        except RefusedError:
            self._leases.pop(lease.id, None)
            raise
        except TimeoutError as error:
            self._give_up(lease)
            if isinstance(error, TimedOutError):
                raise
            raise TimedOutError(_waiting(lease), timeout or 0.0) from error
        except BaseException:
            self._give_up(lease)
            raise
        lease.owner = asyncio.current_task()
        return lease

    async def _ask(self, lease: Lease) -> None:
        status = await self.sender.ask_central(lease.request, timeout=ACKNOWLEDGE_TIMEOUT)
        lease.update(status)

    def _give_up(self, lease: Lease) -> None:
        self._leases.pop(lease.id, None)
        with contextlib.suppress(ClosedError):
            self.core.spawn(self._release(lease.id), name=f"release.{lease.id}")

    def _begin_to_follow(self, lease: Lease) -> None:
        self._leases[lease.id] = lease
        if not self._is_listening:
            self._is_listening = True
            self.topics.listen_to(HoldChanged, self._hear)
            self.core.presence.listen(self._presence_changed)
        if self._keeping is None or self._keeping.done():
            self._keeping = self.core.spawn(self._keep_up(), name=f"{self.core.name}.leases")

    def _hear(self, arrival: Arrival[HoldChanged]) -> None:
        if arrival.sender != CENTRAL:
            return
        lease = self._leases.get(arrival.value.status.id)
        if lease is not None:
            lease.update(arrival.value.status)

    def _presence_changed(self, change: PresenceChange) -> None:
        if change.module.name == CENTRAL and change.appeared:
            self._bell.set()

    async def _keep_up(self) -> None:
        """Ask central every few seconds: what it told may be lost, and central too."""
        while self._leases:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(REFRESH_PERIOD):
                    await self._bell.wait()
            self._bell.clear()
            with contextlib.suppress(*OUT_OF_REACH):
                await self._check()

    async def _check(self) -> None:
        asked = {id: lease for id, lease in self._leases.items() if lease.status is not None}
        if not asked:
            return
        question = CheckHolds(ids=tuple(asked))
        known = {s.id: s for s in await self.sender.ask_central(question, timeout=TRY_TIMEOUT)}
        for id, lease in asked.items():
            if id in known:
                lease.update(known[id])
            elif lease.is_held:
                lease.fail(LeaseLostError(lease.names, "central does not know of it any more"))
            else:
                await self._ask_anew(lease)

    async def _ask_anew(self, lease: Lease) -> None:
        try:
            await self._ask(lease)
        except OUT_OF_REACH:
            raise
        except TcaError as error:
            lease.fail(error)

    async def _release(self, id: str) -> None:
        while True:
            try:
                await self.sender.ask_central(ReleaseResources(id=id), timeout=ACKNOWLEDGE_TIMEOUT)
            except OUT_OF_REACH as error:
                logger.warning("hold %s is not given back yet: %s", id, error)
            except TcaError as error:
                logger.warning("hold %s cannot be given back: %s", id, error)
                return
            else:
                return


def _waiting(lease: Lease) -> str:
    what = f"waiting for {', '.join(lease.names)}"
    why = lease.status.waiting_for if lease.status else None
    return f"{what} ({why})" if why else what
