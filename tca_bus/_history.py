"""The task history in words: what each journalled event says to people."""

from __future__ import annotations

from tca_bus._failure import Failure
from tca_bus._protocol import Outcome, TaskStatus
from tca_bus.tasktree import (
    Abandoned,
    Alarmed,
    Attached,
    CaughtFailure,
    Constrained,
    Deregistered,
    Detached,
    Dispatched,
    HandlerLost,
    HandlerMissing,
    KillRequested,
    Prepared,
    Prioritized,
    RecordedEvent,
    Registered,
    Released,
    Reported,
    Resumed,
    Retried,
    Role,
    Submitted,
    Suspended,
    Taken,
    Triggered,
    UncaughtFailure,
)

_OUTCOMES = {
    Outcome.SUCCESS: "handled",
    Outcome.FAILURE: "handler failed",
    Outcome.KILLED: "handler stopped",
}


def event_words(event: RecordedEvent) -> tuple[str, str]:
    """The word for an event and the sentence that goes with it."""
    match event:
        case Submitted():
            return "submitted", _origin_words(event)
        case Prepared():
            return "prepared", f"by {event.sender}"
        case Constrained():
            return "constrained", str(event.order)
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
            return _change_words(event)


def _origin_words(event: Submitted) -> str:
    task = event.task
    below = f", below {task.parent}" if task.parent else ""
    role = "" if event.origin.role is Role.STEP else f", as {event.origin.role} of {task.parent}"
    return f"{task.task_class} from {task.sender}{role or below}"


def _change_words(event: RecordedEvent) -> tuple[str, str]:
    match event:
        case Suspended():
            return "suspended", "and all below it"
        case Resumed():
            return "resumed", "and all below it"
        case Prioritized():
            return "prioritized", f"to {event.priority}"
        case Retried():
            return "retried", "from the start"
        case Triggered():
            return "triggered", f"for the {event.number}. time"
        case CaughtFailure():
            return "caught", f"by {event.catch.handler}, which is on {event.context}"
        case UncaughtFailure():
            return "uncaught", "no exception handler takes the failure"
        case Attached():
            return "attached", f"{event.what.kind} {event.what.id}"
        case Detached():
            return "detached", event.attachment
        case _:
            return _interruption_words(event)


def _interruption_words(event: RecordedEvent) -> tuple[str, str]:
    match event:
        case KillRequested():
            below = "what is below it: " if event.only_below else ""
            return "kill requested", f"{below}{event.reason}"
        case HandlerLost():
            return "handler lost", f"module {event.module} is gone"
        case HandlerMissing():
            return "no handler", "no module came to handle it"
        case Abandoned():
            return "abandoned", "its handler did not stop in time"
        case Alarmed():
            return "time has come", event.key
        case Registered():
            return "registered", f"{event.what.kind} on {event.message}"
        case Deregistered():
            return "deregistered", event.id
    raise TypeError(f"no words for a {type(event).__name__}")


def end_words(status: TaskStatus) -> tuple[str, str]:
    """The word for the end of a task and the sentence that goes with it."""
    seconds = (status.ended or status.created) - status.created
    why = f"; {_why(status.failure)}" if status.failure else ""
    return status.state.value, f"after {seconds:.1f} s{why}"


def _why(failure: Failure | None) -> str:
    if failure is None:
        return ""
    return failure.text if failure.name == "killed" else failure.sentence()
