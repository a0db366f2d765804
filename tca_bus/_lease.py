"""A hold on resources as its holder has it."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Generator
from types import TracebackType
from typing import TYPE_CHECKING, Any

from tca_bus._errors import LeaseLostError, PendingLimitError, TcaError
from tca_bus._resource_messages import AcquireResources, HoldState, HoldStatus

if TYPE_CHECKING:
    from tca_bus._leases import Leases


class Lease:
    """Resources that this module holds, or waits for.

    ``status`` is the latest state seen, None before central has acknowledged it. It survives
    restarts of central and of the router.
    """

    def __init__(self, request: AcquireResources, keeper: Leases) -> None:
        self.request = request
        self.status: HoldStatus | None = None
        self.owner: asyncio.Task[Any] | None = None
        self._keeper = keeper
        self._error: TcaError | None = None
        self._settled = asyncio.Event()
        self._over = asyncio.Event()
        self._on_loss: Callable[[], object] | None = None

    @property
    def id(self) -> str:
        """The id of the hold."""
        return self.request.id

    @property
    def names(self) -> tuple[str, ...]:
        """The resources."""
        return self.request.names

    @property
    def is_held(self) -> bool:
        """Whether the resources are held now."""
        held = self.status is not None and self.status.state is HoldState.HELD
        return held and not self._over.is_set()

    async def release(self) -> None:
        """Give the resources back; returns when central knows, or is out of reach for a while.

        It is told when it is back.
        """
        self._over.set()
        await self._keeper.let_go(self)

    async def lost(self) -> LeaseLostError:
        """Wait until the resources are taken away, by hand or because this module was lost."""
        while not isinstance(self._error, LeaseLostError):
            await self._over.wait()
            if self._error is None:
                await asyncio.get_running_loop().create_future()
        return self._error

    async def settled(self) -> None:
        """Wait until it is held.

        Raises:
            TcaError: It will not be.
        """
        await self._settled.wait()
        if self._error is not None:
            raise self._error

    def update(self, status: HoldStatus) -> None:
        """Take a state from central, if it is newer than the one at hand."""
        if self._over.is_set():
            return
        if self.status is not None and status.sequence <= self.status.sequence:
            return
        was_held, self.status = self.is_held, status
        if status.state is HoldState.HELD:
            self._settled.set()
        elif status.state is HoldState.ENDED or was_held:
            self.fail(self._loss(status))

    def fail(self, error: TcaError) -> None:
        """It is held no more, or never will be."""
        self._error = error
        self._over.set()
        self._settled.set()
        if self._on_loss is not None:
            self._on_loss()

    def call_on_loss(self, function: Callable[[], object] | None) -> None:
        """Have a function called when the resources are taken away."""
        self._on_loss = function

    def _loss(self, status: HoldStatus) -> TcaError:
        failure = status.failure
        if failure is not None and failure.name == "pending_limit":
            return PendingLimitError(f"waiting for {', '.join(self.names)}", failure.text)
        return LeaseLostError(self.names, failure.text if failure else "it was released")


class Acquisition:
    """What `Module.acquire` gives: entered, the block holds the resources; awaited, the caller.

    Entered, the resources are given back at the end of the block. Should they be taken away
    before that, the block is cancelled and `LeaseLostError` comes out of it. Awaited, it gives a
    `Lease` that lasts until it is released, or the task in whose handler it was taken has ended,
    or the module.
    """

    def __init__(self, take: Callable[[], Coroutine[Any, Any, Lease]]) -> None:
        self._take = take
        self._lease: Lease | None = None
        self._task: asyncio.Task[Any] | None = None
        self._cancelling = 0
        self._is_interrupted = False

    def __await__(self) -> Generator[Any, None, Lease]:
        return self._take().__await__()

    async def __aenter__(self) -> Lease:
        self._lease = lease = await self._take()
        self._task = asyncio.current_task()
        self._cancelling = self._task.cancelling() if self._task else 0
        lease.call_on_loss(self._interrupt)
        if not lease.is_held:
            self._interrupt()
        return lease

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        lease, task = self._lease, self._task
        assert lease is not None
        assert task is not None
        lease.call_on_loss(None)
        if not self._is_interrupted:
            await lease.release()
            return
        is_ours = task.uncancel() <= self._cancelling and kind is asyncio.CancelledError
        if is_ours:
            raise await lease.lost() from error

    def _interrupt(self) -> None:
        if self._task is not None and not self._is_interrupted:
            self._is_interrupted = True
            self._task.cancel()
