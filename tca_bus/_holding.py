"""Taking resources: for a module, or for the task that a handler works on."""

from __future__ import annotations

from abc import ABC, abstractmethod

from tca_bus._lease import Acquisition
from tca_bus._resource_messages import HoldKind


class Holding(ABC):
    """Takes resources, each by one of three kinds of hold.

    A *thing* is anything in the world that only so many may use: a lift, a door, a charger. It is
    there as soon as somebody names it, with one place unless `Module.declare` says more. A
    handlers' resource is ``MODULE/NAME``, with a message's name for one outside all resources, and
    ``MODULE/`` for all handlers of a module.

    Each gives an `Acquisition`: ``async with`` holds for the length of a block, ``await`` gives a
    `Lease` to be released. What is taken in a handler ends with its task at the latest, what a
    module takes with the module.
    """

    def acquire(self, *names: str, priority: int = 0, timeout: float | None = None) -> Acquisition:
        """Take a place of each of these things, all at once, as soon as all have one free.

        First come first served within a priority, the highest first. Who waits for several is not
        overtaken at any of them. With ``timeout`` None it waits for as long as it takes.

        Raises, when it is awaited or entered:
            DeadlockError: Whoever has one of them waits, in the end, for what this asyncio task
                holds already; it names the members of the ring.
            PendingLimitError: More wait than may, and this was the oldest of the lowest priority.
            TimedOutError: Not its turn within ``timeout`` wall seconds; it says who has them.
            LeaseLostError: They were taken away, by ``tca unlock``, say.
            NoHandlerError: There is no central.
        """
        return self._hold(HoldKind.LEASE, names, priority=priority, timeout=timeout)

    def lock(self, name: str, *, timeout: float | None = None) -> Acquisition:
        """Let nobody's messages, or leases, through to a resource (``tcaLockResource``).

        It begins when those who have it have ended, and comes before all who wait. A handler may
        lock the resource that it is in.

        Raises, when it is awaited or entered:
            RefusedError: There is no such resource, or this module has a lock or reservation of it.
            TimedOutError: It did not begin within ``timeout`` wall seconds.
        """
        return self._hold(HoldKind.LOCK, (name,), priority=0, timeout=timeout)

    def reserve(self, name: str, *, timeout: float | None = None) -> Acquisition:
        """Let only this module's messages, or leases, through (``tcaReserveResource``).

        Otherwise as `lock`.
        """
        return self._hold(HoldKind.RESERVATION, (name,), priority=0, timeout=timeout)

    @abstractmethod
    def _hold(
        self, kind: HoldKind, names: tuple[str, ...], *, priority: int, timeout: float | None
    ) -> Acquisition:
        """Make the acquisition."""
