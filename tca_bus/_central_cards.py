"""What central takes from the card of a module."""

from __future__ import annotations

from tca_bus._messages import MessageClass
from tca_bus._presence import PresentModule
from tca_bus._protocol import ModuleCard, ProvidedMessage, ProvidedResource
from tca_bus.tasktree import OWN, HandlerResource, ProviderAppeared

TASKS = frozenset({MessageClass.GOAL, MessageClass.COMMAND, MessageClass.EXCEPTION})

UNLIMITED = 1_000_000
"""How many monitors may test one condition."""


def introduction(time: float, module: PresentModule, card: ModuleCard) -> ProviderAppeared:
    """The event of a module that has said what it handles for central, and how much of it."""
    tasks = [message for message in card.provides if message.message_class in TASKS]
    names = tuple(message.name for message in tasks)
    members: dict[str, list[str]] = {resource.name: [] for resource in card.resources}
    for message in tasks:
        if message.resource is not None:
            members.setdefault(message.resource, []).append(message.name)
    return ProviderAppeared(
        time,
        module.name,
        module.incarnation,
        {message.name: _capacity(message) for message in card.provides},
        resources=tuple(_resource(r, module.name, names, members) for r in card.resources),
        limits={message.name: message.pending for message in tasks if message.pending},
    )


def _capacity(provided: ProvidedMessage) -> int:
    """How many nodes of a message a module takes at once; conditions are no work."""
    return provided.capacity or 1 if provided.message_class in TASKS else UNLIMITED


def _resource(
    shared: ProvidedResource, module: str, tasks: tuple[str, ...], members: dict[str, list[str]]
) -> HandlerResource:
    if shared.name == module:
        return HandlerResource(OWN, shared.capacity, tasks, shared.pending)
    return HandlerResource(
        shared.name, shared.capacity, tuple(members[shared.name]), shared.pending
    )
