"""With what a goal or command may be sent."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypedDict

from tca_bus._attachments import Attachment
from tca_bus._messages import ModuleLostPolicy, UnhandledPolicy
from tca_bus._orders import Order
from tca_bus._protocol import Constraint


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
