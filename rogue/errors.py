"""What can be wrong with a request: facts as attributes, and a sentence that says what is right."""

from __future__ import annotations

from collections.abc import Iterable

from rogue.messages import Refusal
from tca_bus import TaskError, TcaError, did_you_mean, near_matches, near_or_all


class RequestError(TcaError, ValueError):
    """A request that cannot be accepted; ``refusal`` names the kind."""

    exit_code = 2

    def __init__(self, refusal: Refusal, text: str) -> None:
        self.refusal = refusal
        super().__init__(text)

    def as_task_error(self) -> TaskError:
        """This error as a handler raises it, so that it crosses the bus with its name."""
        return TaskError(self.refusal.value, str(self))


class UnknownNameError(RequestError):
    """A user, item or room that is not known; ``near`` are names that look like it."""

    def __init__(self, refusal: Refusal, kind: str, name: str, known: Iterable[str]) -> None:
        known = list(known)
        self.name, self.near = name, near_matches(name, known)
        super().__init__(refusal, f"there is no {kind} {name!r}.{near_or_all(name, known)}")


class UnknownRequestError(RequestError):
    """No request has this id."""

    def __init__(self, request_id: str, known: Iterable[str]) -> None:
        self.request_id = request_id
        hint = did_you_mean(request_id, known) or " 'rogue requests' lists them."
        super().__init__(Refusal.UNKNOWN_REQUEST, f"there is no request {request_id!r}.{hint}")


class SameRoomError(RequestError):
    """Pickup and delivery are one and the same room."""

    def __init__(self, room: str) -> None:
        self.room = room
        super().__init__(
            Refusal.SAME_ROOM,
            f"pickup and delivery are both {room}; name another room with --from or --to",
        )


class DeadlineError(RequestError):
    """A deadline that cannot be read or that has passed."""

    def __init__(self, deadline: str, problem: str) -> None:
        self.deadline, self.problem = deadline, problem
        super().__init__(
            Refusal.BAD_DEADLINE,
            f"deadline {deadline!r} {problem}; expected a time to come, as ISO 8601 "
            "(2026-03-01T14:30), as HH:MM, or from now on as +30m, 90min, 1h or 1h30m",
        )


class IdTakenError(RequestError):
    """The id belongs to another request."""

    def __init__(self, request_id: str) -> None:
        self.request_id = request_id
        super().__init__(
            Refusal.ID_TAKEN, f"request id {request_id!r} belongs to another request; use a new one"
        )


class StoreError(TcaError):
    """The file in which requests are kept cannot be used."""

    exit_code = 2

    def __init__(self, path: str, problem: str) -> None:
        self.path, self.problem = path, problem
        super().__init__(f"{path}: {problem}")


class DirectoryError(TcaError, ValueError):
    """The people directory cannot be read."""

    exit_code = 2

    def __init__(self, path: str, problem: str) -> None:
        self.path, self.problem = path, problem
        super().__init__(f"people directory {path}: {problem}")
