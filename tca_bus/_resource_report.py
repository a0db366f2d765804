"""All resources with who holds them and who waits, for people and scripts."""

from __future__ import annotations

from collections.abc import Iterator

from tca_bus._resource_messages import ResourceStatus, ResourceUser
from tca_bus.resources import HANDLERS, Hold, Ledger, Member
from tca_bus.tasktree import OWN, HandlerResource, Provider, Tree, full_name


class Report:
    """The state of all resources at one moment; ``tasks`` are those that may close a ring."""

    def __init__(self, ledger: Ledger, tree: Tree, tasks: list[str]) -> None:
        self._ledger = ledger
        self._tree = tree
        self._rings = [(set(ring), ledger.words(ring)) for ring in ledger.rings(tasks)]

    def resources(self) -> list[ResourceStatus]:
        """Things first, then the handlers' by module."""
        things = [self._thing(n) for n in self._ledger.book.names() if HANDLERS not in n]
        handlers = {status.name: status for status in self._handlers()}
        absent = [n for n in self._ledger.book.names() if HANDLERS in n and n not in handlers]
        handlers.update((name, self._absent(name)) for name in absent)
        return [*things, *(handlers[name] for name in sorted(handlers))]

    def _thing(self, name: str) -> ResourceStatus:
        book = self._ledger.book
        return ResourceStatus(
            name=name,
            kind="thing",
            capacity=book.capacity(name),
            pending=book.limit(name),
            holders=self._holds(name, waiting=False),
            waiters=self._holds(name, waiting=True),
            dropped=book.dropped[name],
            cycles=self._cycles({("hold", hold.id) for hold in book.at(name)}),
        )

    def _handlers(self) -> Iterator[ResourceStatus]:
        for provider in self._tree.pools.providers():
            if provider.present and provider.is_introduced:
                for resource in provider.resources.values():
                    name = full_name(provider.module, resource.name)
                    held = self._ledger.book.at(name)
                    if resource.name != OWN or resource.capacity is not None or held:
                        yield self._of_handlers(name, provider, resource)

    def _of_handlers(
        self, name: str, provider: Provider, resource: HandlerResource
    ) -> ResourceStatus:
        pools = self._tree.pools
        attending, waiting = provider.attending(resource), pools.waiting(resource)
        members: set[Member] = {("task", id) for id in [*attending, *waiting]}
        members |= {("hold", hold.id) for hold in self._ledger.book.at(name)}
        return ResourceStatus(
            name=name,
            kind="handlers",
            capacity=resource.capacity,
            pending=resource.pending or provider.limits.get(resource.name),
            messages=resource.messages,
            holders=[*self._holds(name, waiting=False), *map(self._task, attending)],
            waiters=[*self._holds(name, waiting=True), *map(self._task, waiting)],
            dropped=pools.dropped(name),
            cycles=self._cycles(members),
        )

    def _absent(self, name: str) -> ResourceStatus:
        """A handlers' resource that is held while its module is away."""
        return ResourceStatus(
            name=name,
            kind="handlers",
            capacity=None,
            pending=None,
            holders=self._holds(name, waiting=False),
            waiters=self._holds(name, waiting=True),
        )

    def _holds(self, name: str, *, waiting: bool) -> list[ResourceUser]:
        found = self._ledger.book.at(name)
        return [self._hold(hold) for hold in found if (hold.granted is None) is waiting]

    def _hold(self, hold: Hold) -> ResourceUser:
        status = self._ledger.status(hold.id)
        return ResourceUser(
            id=hold.id,
            kind=hold.request.kind.value,
            module=hold.module,
            task=hold.request.task,
            priority=hold.request.priority,
            since=hold.granted or hold.asked,
            waiting_for=status.waiting_for if status else None,
        )

    def _task(self, id: str) -> ResourceUser:
        abandoned = None if id in self._tree else self._tree.abandoned(id)
        status = abandoned or self._tree.status(id)
        return ResourceUser(
            id=id,
            kind="task",
            module=status.sender,
            task=id,
            priority=status.priority,
            since=status.started or status.created,
            waiting_for="its handler to stop" if abandoned else status.waiting_for,
        )

    def _cycles(self, members: set[Member]) -> list[str]:
        return [words for ring, words in self._rings if ring & members]
