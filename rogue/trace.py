"""The words of the conversation, as Figure 6 of Haigh & Veloso (1996) prints them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rogue.messages import DeliveryRequest
from rogue.times import show_deadline, show_time

MARGIN = " " * 10
"""What ROGUE itself says stands ten columns in; the planner's node lines do not."""

LISTENING = "Listening for incoming requests..."
ACHIEVED = "Achieved top-level goals."


def message_line(request: DeliveryRequest) -> str:
    """That a request came in."""
    words = (
        request.user,
        request.item,
        show_time(request.posted),
        show_deadline(request.deadline),
        request.pickup,
        request.deliver,
    )
    return "Message from interface: " + " ".join(f'"{word}"' for word in words)


def priority_lines(requests: Iterable[DeliveryRequest]) -> list[str]:
    """The block in which the ranks of new requests are worked out."""
    lines = ["", f"{MARGIN}CALCULATING PRIORITIES"]
    for request in requests:
        goal = f"#<HAS-ITEM {request.user.upper()} {request.item.upper()}>"
        lines.append(f"{MARGIN}Request: {goal}    Rank: {request.rank}")
    return [*lines, ""]


def double_float(value: float) -> str:
    """A number as Common Lisp writes a double: ``567.0d0``."""
    return f"{round(value, 1):.1f}d0"


def navigate_lines(x: float, y: float) -> list[str]:
    """The goal that is sent to the navigator, at (x, y) in map units."""
    location = f"#(TASK-CONTROL::MAPLOCDATA {double_float(x)} {double_float(y)})"
    return [
        f'{MARGIN}SENDING COMMAND (TCAEXPANDGOAL "navigateToG" {location})',
        f"{MARGIN}...waiting...",
    ]


def say_line(text: str) -> str:
    """A sentence that is sent to the speech board."""
    return f'{MARGIN}SENDING COMMAND (TCAEXECUTECOMMAND "C_say" "{text}")'


def action_line(name: str, outcome: str) -> str:
    """How an action of another module ended."""
    return f"{MARGIN}Action {name}-{outcome} finished."


def verifying_line(room: str) -> str:
    """That the place is going to be checked."""
    return f"{MARGIN}Verifying Location: {room.upper()}"


def remark(text: str) -> str:
    """Something that the paper's run had no occasion to say."""
    return f"{MARGIN}{text}"


def prompt_line(question: str, answer: str) -> str:
    """A question on the keyboard with what was typed."""
    return f"{question}: {answer}"


def completed_line(action: str, *arguments: str) -> str:
    """That an action of ROGUE came to its end well."""
    return f"{MARGIN}COMPLETED-ACTION ({action} 1 {' '.join(arguments)})"


def failed_line(action: str, *arguments: str) -> str:
    """That an action of ROGUE came to nothing."""
    return f"{MARGIN}FAILED-ACTION ({action} 0 {' '.join(arguments)})"


def show_choices(choices: Sequence[str]) -> str:
    """The answers that a question takes, as the keyboard shows them: ``(y/i(mpossible))``."""
    full = {"i": "i(mpossible)"}
    return f"({'/'.join(full.get(choice, choice) for choice in choices)})" if choices else ""
