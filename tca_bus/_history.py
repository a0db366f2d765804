"""The task history in words: what each journalled event says to people."""

from __future__ import annotations

from tca_bus._failure import Failure
from tca_bus._protocol import Outcome, TaskStatus
from tca_bus.tasktree import (
    Dispatched,
    HandlerLost,
    HandlerMissing,
    KillRequested,
    RecordedEvent,
    Released,
    Reported,
    Submitted,
    Taken,
)

_OUTCOMES = {
    Outcome.SUCCESS: "handled",
    Outcome.FAILURE: "handler failed",
    Outcome.KILLED: "handler stopped",
}


def event_words(event: RecordedEvent) -> tuple[str, str]:
    """The word for an event and the sentence that goes with it."""
    match event:
        case Submitted(task=task):
            below = f", below {task.parent}" if task.parent else ""
            return "submitted", f"{task.task_class} from {task.sender}{below}"
        case Released():
            return "released", f"{event.point.value} of {event.previous}"
        case Dispatched():
            again = f", try {event.attempt}" if event.attempt > 1 else ""
            return "dispatched", f"to {event.module}{again}"
        case Taken():
            return "started", "its handler has it"
        case Reported():
            return _OUTCOMES[event.outcome], _why(event.failure)
        case _:
            return _interruption_words(event)


def _interruption_words(event: KillRequested | HandlerLost | HandlerMissing) -> tuple[str, str]:
    match event:
        case KillRequested():
            below = "what is below it: " if event.only_below else ""
            return "kill requested", f"{below}{event.reason}"
        case HandlerLost():
            return "handler lost", f"module {event.module} is gone"
        case HandlerMissing():
            return "no handler", "no module came to handle it"


def end_words(status: TaskStatus) -> tuple[str, str]:
    """The word for the end of a task and the sentence that goes with it."""
    seconds = (status.ended or status.created) - status.created
    why = f"; {_why(status.failure)}" if status.failure else ""
    return status.state.value, f"after {seconds:.1f} s{why}"


def _why(failure: Failure | None) -> str:
    if failure is None:
        return ""
    return failure.text if failure.name == "killed" else failure.sentence()
