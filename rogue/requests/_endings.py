"""How a request ends: at once, or only when what the robot carries for it is somewhere."""

from __future__ import annotations

from typing import Literal

from rogue.memory import Facts, Step
from rogue.messages import Closing, DeliveryRequest, RequestState

Item = Literal["back", "deliver", "keep"]
"""What becomes of an item on the tray whose request is taken back."""


def closes(
    request: DeliveryRequest, closing: Closing, item: Item, facts: Facts, step: Step | None
) -> DeliveryRequest | None:
    """An open request that is given up while its item is on the tray, or being handed over.

    None when there is nothing to wait for, and it ends at once.

    Args:
        request: the open request.
        closing: how it ends, and why; one that closes already ends as was decided first.
        item: what becomes of its item.
        facts: what is known of the world.
        step: the step that is being carried out.
    """
    carried = is_carried(request, facts) or is_handed_over(request, step)
    if item == "keep" or not carried:
        return None
    return request.model_copy(update={"then": item, "closing": request.closing or closing})


def ended(
    request: DeliveryRequest, state: RequestState, reason: str | None, now: float
) -> DeliveryRequest:
    """A request that has ended; one that was closing ends as was decided then."""
    closing = request.closing
    if closing is not None and reason != closing.reason:
        state, reason = closing.state, f"{closing.reason}; {reason or _arrived(request)}"
    fields = {"state": state, "reason": reason, "finished": now, "warning": None}
    return request.model_copy(update=fields)


def is_carried(request: DeliveryRequest, facts: Facts) -> bool:
    """Whether what lies on the tray is the item of this request, and not of one like it."""
    begun = request.state in {RequestState.UNDERWAY, RequestState.SUSPENDED}
    return begun and (request.user, request.item) in facts.tray


def is_handed_over(request: DeliveryRequest, step: Step | None) -> bool:
    """Whether somebody is putting the item on the tray, or taking it from there."""
    return step is not None and request.id in step.requests and not step.operator.startswith("goto")


def _arrived(request: DeliveryRequest) -> str:
    if request.then == "back":
        return f"the item is back in {request.pickup}"
    return f"the item was delivered to {request.deliver} all the same"
