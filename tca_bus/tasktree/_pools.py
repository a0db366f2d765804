"""Who can handle what, and which nodes wait for them: one queue per message name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from tca_bus.tasktree._queue import Key, Priority, Queue, rank_of
from tca_bus.tasktree._resources import OWN, Gate, HandlerResource, Provider, full_name


@dataclass(frozen=True, slots=True)
class Assignment:
    """A node and the provider chosen for it."""

    id: str
    module: str
    incarnation: str


@dataclass(frozen=True, slots=True)
class Overflow:
    """A node that has to go: more wait for ``resource`` than its ``limit``."""

    id: str
    resource: str
    limit: int


_Order = tuple[Key, int]
"""The place of a node, then how much its provider has."""


@dataclass(slots=True)
class _Wait:
    name: str
    sender: str
    only: str | None


class Pools:
    """The providers of each message, and the nodes that are ready for one.

    Of several providers the one with the fewest nodes gets the next; of several waiting nodes
    the one with the highest priority goes first, else the one that came first, also among
    messages that share a resource. A node that waits for what others are free to take does not
    hold them up.
    """

    def __init__(self) -> None:
        self._providers: dict[str, Provider] = {}
        self._by_name: dict[str, dict[str, Provider]] = {}
        self._queues: dict[str, Queue] = {}
        self._waiting: dict[str, _Wait] = {}
        self._gates: dict[str, Gate] = {}
        self._missing: dict[str, int] = {}
        self._unheard: dict[str, None] = {}
        self._unsettled: dict[str, None] = {}
        self._unlimited: dict[str, None] = {}
        self._picky: Counter[str] = Counter()
        self._dropped: Counter[str] = Counter()
        self._serial = 0

    def appear(
        self,
        module: str,
        incarnation: str,
        capacities: Mapping[str, int],
        *,
        resources: tuple[HandlerResource, ...] = (),
        limits: Mapping[str, int] | None = None,
        is_introduced: bool = True,
    ) -> None:
        """Add a provider, or change what is known of it.

        ``limits`` says how many of a message may wait. One that has not introduced itself yet
        gets nothing while any resource of its module is held.
        """
        known = self._providers.get(incarnation)
        provider = known or Provider(module, incarnation, {}, is_introduced=False)
        self._unlist(provider)
        provider.present = True
        if is_introduced or not provider.is_introduced:
            provider.is_introduced = is_introduced
            provider.introduce(capacities, resources, limits or {})
        else:
            provider.rename(capacities)
        self._providers[incarnation] = provider
        for name in provider.capacities:
            self._by_name.setdefault(name, {})[incarnation] = provider
            for id in self._queues.get(name, ()):
                if self._has_provider(self._waiting[id]):
                    self._missing.pop(id, None)
                    self._unheard.pop(id, None)
        self._look_again(provider)

    def lose(self, incarnation: str) -> tuple[str, list[str]]:
        """Remove a provider; gives its module's name and the nodes that it had."""
        provider = self._providers.pop(incarnation, None)
        if provider is None:
            return "", []
        self._unlist(provider)
        return provider.module, provider.attended()

    def names(self) -> set[str]:
        """The messages that somebody handles."""
        return set(self._by_name)

    def provides(self, name: str) -> list[Provider]:
        """The present providers of a message."""
        return list(self._by_name.get(name, {}).values())

    def providers(self) -> list[Provider]:
        """All that are present or have nodes."""
        return list(self._providers.values())

    def incarnations(self) -> dict[str, str]:
        """The incarnations that have nodes or are present, with the names of their modules."""
        return {p.incarnation: p.module for p in self._providers.values()}

    def wait(
        self,
        id: str,
        name: str,
        priority: Priority,
        *,
        only: str | None = None,
        sender: str = "",
    ) -> None:
        """Queue a node that is ready for its handler, perhaps for one in module ``only``.

        ``sender`` is the module from which it comes. One that waits already keeps its age.
        """
        self._serial += 1
        serial = self._queues[name].key(id)[1] if id in self._waiting else self._serial
        missing = self._missing.get(id)
        self.forget(id)
        wait = self._waiting[id] = _Wait(name, sender, only)
        self._picky[name] += only is not None
        queue = self._queues.setdefault(name, Queue())
        queue.put(id, (rank_of(priority), serial))
        self._unsettled[name] = self._unlimited[name] = None
        if self._has_provider(wait):
            return
        if missing is None:
            self._unheard[id] = None
        else:
            self._missing[id] = missing

    def reprioritise(self, id: str, priority: Priority) -> None:
        """Move a waiting node to another priority; there it is as old as it is."""
        wait = self._waiting.get(id)
        if wait is not None:
            queue = self._queues[wait.name]
            queue.put(id, (rank_of(priority), queue.key(id)[1]))
            self._unsettled[wait.name] = None

    def forget(self, id: str) -> None:
        """Take a node out of the queues."""
        wait = self._waiting.pop(id, None)
        if wait is not None:
            self._queues[wait.name].discard(id)
            self._picky[wait.name] -= wait.only is not None
        self._missing.pop(id, None)
        self._unheard.pop(id, None)

    def drop(self, id: str, resource: str) -> None:
        """Take out a node because of a limit; counted for the resource."""
        wait = self._waiting.get(id)
        if wait is not None:
            self._queues[wait.name].drop(id)
            self._dropped[resource] += 1
        self.forget(id)

    def occupy(self, id: str, name: str, module: str, incarnation: str) -> None:
        """Count a node on the provider that has it now."""
        self.forget(id)
        provider = self._providers.get(incarnation)
        if provider is None:
            provider = Provider(module, incarnation, {}, present=False)
            self._providers[incarnation] = provider
        provider.working.setdefault(name, {})[id] = None

    def release(self, id: str, name: str, incarnation: str) -> None:
        """Give back the place of a node whose handler has ended."""
        provider = self._providers.get(incarnation)
        if provider is None:
            return
        provider.working.get(name, {}).pop(id, None)
        if not provider.present and not provider.attended():
            del self._providers[incarnation]
        self._look_again(provider)

    def set_gate(self, resource: str, gate: Gate | None) -> None:
        """Say who holds a resource, by its full name; None when nobody does any more."""
        if gate is None:
            self._gates.pop(resource, None)
        else:
            self._gates[resource] = gate
        for provider in self._providers.values():
            self._look_again(provider)

    def assign(self) -> Assignment | None:
        """Choose the next node that can be handled now, and its provider."""
        best: tuple[_Order, Assignment] | None = None
        for name in list(self._unsettled):
            match = self._match(name)
            if match is None:
                self._settled(name)
            elif best is None or match[0] < best[0]:
                best = match
        return best[1] if best else None

    def overflow(self) -> Overflow | None:
        """Once nothing more can be assigned: a node that is more than may wait.

        It is the oldest of the lowest priority. Of several providers the one that lets the most
        wait decides.
        """
        for name in list(self._unlimited):
            excess = [self._excess(provider, name) for provider in self.provides(name)]
            found = [each for each in excess if each is not None]
            if found and len(found) == len(excess):
                return found[0]
            del self._unlimited[name]
        return None

    def newly_missing(self) -> Iterator[tuple[str, int]]:
        """Waiting nodes for which nobody is there and that were not told of before."""
        unheard, self._unheard = self._unheard, {}
        for id in unheard:
            self._serial += 1
            self._missing[id] = self._serial
            yield id, self._serial

    def forget_missing(self) -> None:
        """Tell of all waiting nodes again."""
        self._missing.clear()
        self._unheard = {
            id: None for id, wait in self._waiting.items() if not self._has_provider(wait)
        }

    def is_missing(self, id: str, number: int) -> bool:
        """Whether that wait of the node still lasts."""
        return self._missing.get(id) == number

    def attending(self, resource: str) -> list[str]:
        """The nodes that have a place in a resource, by its full name."""
        return [
            id
            for provider in self._providers.values()
            for one in provider.resources.values()
            if full_name(provider.module, one.name) == resource
            for id in provider.attending(one)
        ]

    def waiting(self, resource: HandlerResource) -> list[str]:
        """The nodes that wait for one of the messages of a resource, the next one first."""
        queues = [self._queues[name] for name in resource.messages if name in self._queues]
        keys = {id: queue.key(id) for queue in queues for id in queue}
        return sorted(keys, key=keys.__getitem__)

    def dropped(self, resource: str) -> int:
        """How many nodes its limits have dropped, by its full name."""
        return self._dropped[resource]

    def blockers(self, id: str) -> tuple[set[str], set[str]] | None:
        """The nodes, and the holders, of which any may have to go before a waiting node.

        None when it does not wait, or waits for a module to come.
        """
        wait = self._waiting.get(id)
        if wait is None or not self._has_provider(wait):
            return None
        nodes, holders = set[str](), set[str]()
        for provider in self._may_take(wait):
            for full in provider.full(wait.name):
                nodes.update(provider.attending(full))
            gates = provider.gates(wait.name, self._gates)
            holders.update(gate.holder for gate in gates if gate.only != wait.sender)
        return nodes, holders

    def why(self, id: str, name: str) -> str:
        """What a waiting node waits for, in words."""
        providers = self.provides(name)
        if not providers:
            return f"a module that handles {name!r}"
        sender = self._waiting[id].sender if id in self._waiting else ""
        return " or ".join(self._why(provider, name, sender) for provider in providers)

    def _why(self, provider: Provider, name: str, sender: str) -> str:
        shut = [g for g in provider.gates(name, self._gates) if g.only is None or g.only != sender]
        if shut:
            return f"{provider.module}, which is held by {shut[0].words or shut[0].holder}"
        full = [r for r in provider.full(name) if r.name not in {name, OWN}]
        if full:
            count = len(provider.attending(full[0]))
            return f"{provider.module}, which has {count} in its resource {full[0].name!r}"
        return f"{provider.module}, which has {provider.load(name)} of {name!r}"

    def _unlist(self, provider: Provider) -> None:
        """Take a provider out of the index; nodes that nobody else takes begin to miss it."""
        for name in provider.capacities:
            others = self._by_name.get(name, {})
            others.pop(provider.incarnation, None)
            self._unlimited[name] = None
            if not others:
                self._by_name.pop(name, None)
            if not others or self._picky[name]:
                waits = {id: self._waiting[id] for id in self._queues.get(name, ())}
                left = [id for id, wait in waits.items() if not self._has_provider(wait)]
                self._unheard.update(dict.fromkeys(left))

    def _has_provider(self, wait: _Wait) -> bool:
        return bool(self._may_take(wait))

    def _may_take(self, wait: _Wait) -> list[Provider]:
        return [p for p in self.provides(wait.name) if wait.only in {None, p.module}]

    def _look_again(self, provider: Provider) -> None:
        for name in provider.capacities:
            if self._queues.get(name):
                self._unsettled[name] = self._unlimited[name] = None

    def _settled(self, name: str) -> None:
        del self._unsettled[name]
        if name in self._queues and not self._queues[name]:
            del self._queues[name]

    def _match(self, name: str) -> tuple[_Order, Assignment] | None:
        """The best pair of a waiting node and a provider that takes it now."""
        best: tuple[_Order, Assignment] | None = None
        for provider in self.provides(name):
            id = self._next_for(provider, name) if provider.is_free(name) else None
            if id is None:
                continue
            order = (self._queues[name].key(id), provider.share(name))
            if best is None or order < best[0]:
                best = order, Assignment(id, provider.module, provider.incarnation)
        return best

    def _next_for(self, provider: Provider, name: str) -> str | None:
        """The first waiting node that the holders of the provider's resources let pass."""
        queue = self._queues.get(name)
        if queue is None:
            return None
        gates = provider.gates(name, self._gates)
        if not gates and not self._picky[name]:
            return queue.head()
        waits = ((id, self._waiting[id]) for id in queue)
        fitting = ((id, wait) for id, wait in waits if wait.only in {None, provider.module})
        passing = (id for id, wait in fitting if all(gate.only == wait.sender for gate in gates))
        return next(passing, None)

    def _excess(self, provider: Provider, name: str) -> Overflow | None:
        queue, limit = self._queues.get(name), provider.limits.get(name)
        if queue is not None and limit is not None and len(queue) > limit:
            return Overflow(queue.victim(), full_name(provider.module, name), limit)
        for resource in provider.path(name):
            if resource.pending is not None:
                victim = self._victim(resource, resource.pending)
                if victim is not None:
                    key = full_name(provider.module, resource.name)
                    return Overflow(victim, key, resource.pending)
        return None

    def _victim(self, resource: HandlerResource, limit: int) -> str | None:
        queues = [q for q in map(self._queues.get, resource.messages) if q]
        if sum(map(len, queues)) <= limit:
            return None
        keys = {queue.victim(): queue.key(queue.victim()) for queue in queues}
        lowest = max(rank for rank, _ in keys.values())
        return min((id for id in keys if keys[id][0] == lowest), key=keys.__getitem__)
