"""The resources of handlers: which of them share a capacity, and who may use them now."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace


@dataclass(frozen=True, slots=True)
class HandlerResource:
    """Handlers of one module that share a capacity, as the module announces them.

    ``capacity`` is how many nodes they have at once, ``pending`` how many may wait for them; None
    is no bound.
    """

    name: str
    capacity: int | None
    messages: tuple[str, ...]
    pending: int | None = None


@dataclass(frozen=True, slots=True)
class Gate:
    """Somebody holds a resource: only messages of module ``only`` pass, or nobody's (None).

    ``holder`` is the id of the hold, ``words`` says whose it is.
    """

    holder: str
    only: str | None = None
    words: str = ""


OWN = ""
"""The name of a module's own resource within it; among all modules it is ``MODULE/``."""


def full_name(module: str, resource: str) -> str:
    """The name of a handlers' resource among all modules."""
    return f"{module}/{resource}"


@dataclass(slots=True)
class Provider:
    """One incarnation of a module: how many of which message it takes, and which it has.

    A message outside all ``resources`` has one of its own, of its name. Above them all stands the
    module's own resource: it has no bound unless one is announced, and who holds it holds them
    all.
    """

    module: str
    incarnation: str
    capacities: Mapping[str, int]
    present: bool = True
    resources: Mapping[str, HandlerResource] = field(default_factory=dict)
    limits: Mapping[str, int] = field(default_factory=dict)
    is_introduced: bool = True
    working: dict[str, dict[str, None]] = field(default_factory=dict)

    def introduce(
        self,
        capacities: Mapping[str, int],
        resources: tuple[HandlerResource, ...],
        limits: Mapping[str, int],
    ) -> None:
        """Take what the module says of itself."""
        self.capacities, self.limits = dict(capacities), dict(limits)
        own = {name: HandlerResource(name, count, (name,)) for name, count in capacities.items()}
        grouped = {name for r in resources if r.name != OWN for name in r.messages}
        alone = {name: resource for name, resource in own.items() if name not in grouped}
        announced = {resource.name: resource for resource in resources}
        everything = HandlerResource(OWN, None, tuple(capacities))
        self.resources = {OWN: everything, **alone, **announced}

    def rename(self, capacities: Mapping[str, int]) -> None:
        """Take other messages than before, until the module says more of them."""
        known = {name: self.capacities.get(name, count) for name, count in capacities.items()}
        shared = [r for r in self.resources.values() if r.name not in {OWN, *self.capacities}]
        own = [r for r in self.resources.values() if r.name == OWN and r.capacity is not None]
        self.introduce(known, (*shared, *own), self.limits)

    def path(self, name: str) -> Iterator[HandlerResource]:
        """The resources in which a node of the message needs a place."""
        return (r for r in self.resources.values() if name in r.messages)

    def load(self, name: str) -> int:
        """How many nodes of the message it has."""
        return len(self.working.get(name, ()))

    def attending(self, resource: HandlerResource) -> list[str]:
        """The nodes that have a place in the resource."""
        return [id for name in resource.messages for id in self.working.get(name, ())]

    def attended(self) -> list[str]:
        """All nodes that it has."""
        return [id for ids in self.working.values() for id in ids]

    def full(self, name: str) -> list[HandlerResource]:
        """The resources that have no place for one more of the message."""
        return [r for r in self.path(name) if self._is_full(r)]

    def is_free(self, name: str) -> bool:
        """Whether it takes one more of the message now, if nobody holds it."""
        return self.present and name in self.capacities and not self.full(name)

    def share(self, name: str) -> int:
        """How many nodes have a place where one more of the message would go."""
        return max((len(self.attending(r)) for r in self.path(name)), default=0)

    def gates(self, name: str, gates: Mapping[str, Gate]) -> list[Gate]:
        """Who holds what a node of the message needs; all of it, while the module is unknown."""
        if not gates:
            return []
        if not self.is_introduced:
            own = full_name(self.module, OWN)
            return [replace(gate, only=None) for key, gate in gates.items() if key.startswith(own)]
        keys = [full_name(self.module, resource.name) for resource in self.path(name)]
        return [gates[key] for key in keys if key in gates]

    def _is_full(self, resource: HandlerResource) -> bool:
        return resource.capacity is not None and len(self.attending(resource)) >= resource.capacity
