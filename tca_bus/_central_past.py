"""Constraints on tasks that have ended and are in the tree no more."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from tca_bus._orders import Order

if TYPE_CHECKING:
    from tca_bus._central import Central


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
    ended = central.recent.get(order.first.task) or await central.journal.find(order.first.task)
    if ended is None:
        return order
    if not order.delay:
        return None
    return Order(then=order.then, at=(ended.ended or ended.created) + order.delay)
