"""With what a goal or command may be sent."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypedDict

from tca_bus._attachments import Attachment
from tca_bus._messages import ModuleLostPolicy, UnhandledPolicy
from tca_bus._orders import Order
from tca_bus._protocol import Constraint, SubmitTask
from tca_bus._tasks import new_task_id
from tca_bus._traits import TaskTraits
from tca_bus._wire import build


class SendOptions(TypedDict, total=False):
    """How a task is sent; all have defaults.

    ``id`` makes it idempotent: a second call with it, even from a later process, gives the same
    node and its recorded outcome. ``constraints`` are TCA's flags, ``SEQ_ACH`` by default, and
    ``orders`` further constraints that name this task. ``priority`` is that of the whole task at
    the root, below it that among its siblings. ``wait_for_handler`` is how many seconds central
    waits for a module that handles it, ``within`` a deadline in seconds of central's clock,
    ``timeout`` the wall seconds to wait for the acknowledgement. ``attach`` are taps, exception
    handlers and clean-ups that hold from the start. ``on_module_lost`` and ``on_unhandled`` are
    instead of those of the message.
    """

    id: str | None
    constraints: Constraint
    orders: Sequence[Order]
    priority: int | None
    wait_for_handler: float
    within: float | None
    timeout: float
    attach: Sequence[Attachment]
    on_module_lost: ModuleLostPolicy
    on_unhandled: UnhandledPolicy


def submission(
    name: str,
    data: dict[str, Any],
    options: SendOptions,
    *,
    task_class: Literal["goal", "command"],
    revision: int | None,
    traits: TaskTraits,
    sender: str,
    parent: str | None = None,
) -> SubmitTask:
    """Make what is sent to central of a goal or command.

    Raises:
        InvalidMessageError: A value is of no use; it names the field.
    """
    priority = options.get("priority")
    return build(
        SubmitTask,
        id=options.get("id") or new_task_id(sender),
        name=name,
        task_class=task_class,
        message_revision=revision,
        data=data,
        sender=sender,
        parent=parent,
        constraints=int(options.get("constraints", Constraint.SEQ_ACH)),
        priority=traits.priority if priority is None else priority,
        on_module_lost=options.get("on_module_lost", traits.on_module_lost),
        on_unhandled=options.get("on_unhandled", traits.on_unhandled),
        wait_for_handler=options.get("wait_for_handler", 0.0),
        within=options.get("within"),
        grace=traits.grace,
        orders=tuple(options.get("orders", ())),
        attachments=tuple(options.get("attach", ())),
        is_new=not options.get("id"),
    )
