"""The operators of the office domain as the robot carries them out."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from rogue.memory import PastStep, Step
from rogue.messages import DeliveryRequest
from rogue.outcomes import Thing

GOTO_PICKUP = "goto-pickup-loc"
GOTO_DELIVER = "goto-deliver-loc"
ACQUIRE = "acquire-item"
DELIVER = "deliver-item"
RETURN = "return-item"

RECHARGE = "recharge"
"""The robot's own errand; its arguments are the metres x and y of the charger."""

DRIVES = frozenset({GOTO_PICKUP, GOTO_DELIVER})
"""The operators that lead the robot to a room."""

HAND_OVERS = frozenset({ACQUIRE, DELIVER, RETURN})
"""The operators that move a thing to or from the tray."""


TAKING = frozenset({DELIVER, RETURN})
"""The operators in which somebody takes a thing from the tray, and the errand is over."""


def room_of(step: Step | PastStep) -> str:
    """The room in which a step is carried out, or to which it leads."""
    return step.arguments[1] if step.operator in DRIVES else step.arguments[0]


def thing_of(step: Step) -> Thing:
    """The item that is handed over in a step that is no drive."""
    _, user, item = step.arguments
    return user, item


def thing(request: DeliveryRequest) -> Thing:
    """What is carried for a request."""
    return request.user, request.item


def next_room(request: DeliveryRequest, tray: Collection[Thing]) -> str:
    """The room to which the robot has to go next for a request."""
    return request.destination if thing(request) in tray else request.pickup


def served_by(
    operator: str,
    arguments: Sequence[str],
    requests: Sequence[DeliveryRequest],
    tray: Collection[Thing],
) -> list[DeliveryRequest]:
    """The requests for which an operator is carried out."""
    match operator:
        case "goto-pickup-loc":
            return [r for r in requests if r.pickup == arguments[1] and thing(r) not in tray]
        case "goto-deliver-loc":
            bound = [r for r in requests if r.destination == arguments[1]]
            return [r for r in bound if thing(r) in tray] or bound
        case _:
            _, user, item = arguments
            return [r for r in requests if thing(r) == (user, item)][:1]
