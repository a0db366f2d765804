"""Why a request stands where it does, in sentences made from what was recorded."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from rogue.deadlines import show_time
from rogue.messages import DeliveryRequest, RequestState, StepView


def why_sentences(
    request: DeliveryRequest,
    *,
    steps: Sequence[StepView],
    notes: Sequence[tuple[float, str]],
    others: Iterable[DeliveryRequest],
) -> list[str]:
    """The story of a request, the oldest event first, and what it waits for now."""
    events = [(request.posted, _posted(request))]
    events += [(time, _sentence(text)) for time, text in notes if text != request.reason]
    events += [(step.started, _step(step)) for step in steps]
    told = [f"{show_time(time)}: {text}" for time, text in sorted(events, key=lambda e: e[0])]
    return [*told, _standing(request, others)]


def _posted(request: DeliveryRequest) -> str:
    return (
        f"{request.user} asked for {request.item} from {request.pickup} to {request.deliver} "
        f"by {show_time(request.deadline)}; it ranks {request.rank}."
    )


def _step(step: StepView) -> str:
    match step.state:
        case "open":
            return f"{step.operator} is being carried out."
        case "done":
            return f"{step.operator} was carried out."
        case _:
            return f"{step.operator} did not succeed: {step.outcome}."


def _standing(request: DeliveryRequest, others: Iterable[DeliveryRequest]) -> str:
    when = f"{show_time(request.finished)}: " if request.finished is not None else ""
    match request.state:
        case RequestState.COMPLETED:
            return f"{when}It was delivered."
        case RequestState.FAILED:
            return f"{when}It failed: {request.reason}."
        case RequestState.CANCELED:
            return f"{when}It is canceled: {request.reason}."
        case RequestState.UNDERWAY:
            return "It is being served."
    ahead = [other for other in others if other.state is RequestState.UNDERWAY]
    if not ahead:
        return "It waits to be planned."
    served = ", ".join(f"{other.id} (rank {other.rank})" for other in ahead)
    return f"It waits while the robot serves {served}."


def _sentence(text: str) -> str:
    return text if text.endswith(".") else f"{text}."
