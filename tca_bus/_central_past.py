"""Tasks that are in the tree no more, or never were: what is known and said of them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from tca_bus._errors import TaskError, did_you_mean
from tca_bus._orders import Order
from tca_bus._protocol import TaskStatus

if TYPE_CHECKING:
    from tca_bus._central import Central

UNKNOWN_TASK = "unknown_task"
"""The failure name for an id that central has never seen."""


async def find_ended(central: Central, id: str) -> TaskStatus | None:
    """How a task ended, lately or long ago."""
    return central.recent.get(id) or await central.journal.find(id)


def unknown_task(central: Central, id: str, more: str = "") -> TaskError:
    """What is said of an id that central has never seen, with those that are like it."""
    known = [status.id for status in central.lookup("*", "*")]
    return TaskError(UNKNOWN_TASK, f"no task {id!r} here.{did_you_mean(id, known)}{more}")


async def without_past(
    central: Central, orders: Iterable[Order], *, new: str | None = None
) -> list[Order]:
    """The constraints that may hold something; ``new`` is a task that is not in the tree yet.

    One on a task that has ended holds nothing, or until its delay is over.
    """
    found = [await _settled(central, order, new) for order in orders]
    return [order for order in found if order is not None]


async def _settled(central: Central, order: Order, new: str | None) -> Order | None:
    if order.first is None or order.first.task == new or order.first.task in central.tree:
        return order
    ended = await find_ended(central, order.first.task)
    if ended is None:
        return order
    if not order.delay:
        return None
    return Order(then=order.then, at=(ended.ended or ended.created) + order.delay)
