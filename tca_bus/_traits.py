"""What a type of goal or command says of how it is carried out, whoever sends it."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from tca_bus._messages import ModuleLostPolicy, TaskMessage, UnhandledPolicy


class TaskTraits(BaseModel):
    """The defaults of a message type: see the class variables of `TaskMessage`.

    They travel on the card of the module that handles it, and with what central is to send, so
    that a task sent by its wire name is carried out as one that is sent by its type.
    """

    model_config = ConfigDict(frozen=True)

    priority: int = 0
    grace: float = Field(default=10.0, gt=0, allow_inf_nan=False)
    on_module_lost: ModuleLostPolicy = "fail"
    on_unhandled: UnhandledPolicy = "fail_parent"


def traits_of(kind: type[object]) -> TaskTraits:
    """The traits of a message type; the usual ones for what is no task."""
    if not issubclass(kind, TaskMessage):
        return TaskTraits()
    return TaskTraits(
        priority=kind.priority,
        grace=kind.grace,
        on_module_lost=kind.on_module_lost,
        on_unhandled=kind.on_unhandled,
    )
