"""What can be wrong with a request: facts as attributes, and a sentence that says what is right."""

from __future__ import annotations

from collections.abc import Iterable

from rogue.messages import End, Objection, Refusal
from rogue.times import show_deadline, show_minute_after, show_time
from tca_bus import TaskError, TcaError, did_you_mean, near_matches, near_or_all


class RequestError(TcaError, ValueError):
    """A request that cannot be accepted; ``refusal`` names the kind, ``objection`` the facts."""

    exit_code = 2

    def __init__(self, refusal: Refusal, text: str, objection: Objection) -> None:
        self.refusal, self.objection = refusal, objection
        super().__init__(text)

    def as_task_error(self) -> TaskError:
        """This error as a handler raises it, so that it crosses the bus with its name."""
        return TaskError(self.refusal.value, str(self), data=self.objection)


class UnknownNameError(RequestError):
    """A user, item or room that is not known; ``near`` are names that look like it.

    ``field`` is that of the message; ``hint`` ends the sentence.
    """

    def __init__(
        self,
        refusal: Refusal,
        kind: str,
        name: str,
        known: Iterable[str],
        *,
        field: str | None = None,
        hint: str = "",
    ) -> None:
        known = list(known)
        self.name, self.near = name, near_matches(name, known)
        expected = near_or_all(name, known).strip()
        whose = f"{field}: " if field not in {None, kind} else ""
        super().__init__(
            refusal,
            f"{whose}there is no {kind} {name!r}. {expected}{hint}",
            Objection(field=field or kind, value=name, expected=expected),
        )


class UnknownRequestError(RequestError):
    """No request has this id."""

    def __init__(self, request_id: str, known: Iterable[str]) -> None:
        self.request_id = request_id
        expected = (did_you_mean(request_id, known) or " 'rogue requests' lists them.").strip()
        super().__init__(
            Refusal.UNKNOWN_REQUEST,
            f"there is no request {request_id!r}. {expected}",
            Objection(field="id", value=request_id, expected=expected),
        )


class SameRoomError(RequestError):
    """Pickup and delivery are one and the same room."""

    def __init__(self, room: str) -> None:
        self.room = room
        expected = "another room with --from or --to"
        super().__init__(
            Refusal.SAME_ROOM,
            f"pickup and delivery are both {room}; name {expected}",
            Objection(field="deliver", value=room, expected=expected),
        )


class MissingRoomError(RequestError):
    """Nobody knows one of the two rooms; ``question`` is what the user is to be asked."""

    def __init__(self, end: End, question: str, tried: str) -> None:
        self.end, self.question, self.tried = end, question, tried
        expected = f"a room, with {'--from' if end == 'pickup' else '--to'}"
        super().__init__(
            Refusal.MISSING_ROOM,
            f"{end}: nobody knows the room ({tried}); name {expected}",
            Objection(field=end, value=None, expected=expected, question=question),
        )


class DuplicateError(RequestError):
    """The same errand is open already, as request ``other``."""

    exit_code = 7

    def __init__(self, request_id: str, other: str, errand: str) -> None:
        self.request_id, self.other = request_id, other
        expected = "another errand, or --again to have it done once more"
        super().__init__(
            Refusal.DUPLICATE,
            f"{errand} is open already, as request {other!r}; ask for {expected}",
            Objection(field="id", value=request_id, expected=expected, other=other),
        )


class DeadlineError(RequestError):
    """A deadline that cannot be read or that has passed."""

    def __init__(self, deadline: str, problem: str) -> None:
        self.deadline, self.problem = deadline, problem
        expected = (
            "a time to come, as ISO 8601 (2026-03-01T14:30), as HH:MM, "
            "or from now on as +30m, 90min, 1h or 1h30m"
        )
        super().__init__(
            Refusal.BAD_DEADLINE,
            f"deadline {deadline!r} {problem}; expected {expected}",
            Objection(field="deadline", value=deadline, expected=expected),
        )


class MomentError(RequestError):
    """A time that has passed, and cannot be read."""

    def __init__(self, text: str) -> None:
        self.text = text
        expected = "ISO 8601 (2026-03-01T14:30), HH:MM, or so long ago as 30m, 1h or 1h30m"
        super().__init__(
            Refusal.BAD_TIME,
            f"since {text!r} cannot be read; expected {expected}",
            Objection(field="since", value=text, expected=expected),
        )


class TooLateError(RequestError):
    """A deadline that cannot be met; ``earliest`` is when the errand can be done.

    ``alone`` is when it could be done if there were nothing else to do.
    """

    exit_code = 7

    def __init__(self, deadline: float, *, earliest: float, alone: float) -> None:
        self.deadline, self.earliest, self.alone = deadline, earliest, alone
        busy = alone <= deadline
        why = "what was accepted before comes first" if busy else "the way alone takes that long"
        when = f"{show_minute_after(earliest)} is the earliest"
        expected = f"a later deadline, or --anyway to have it tried; {when}"
        super().__init__(
            Refusal.TOO_LATE,
            f"deadline {show_time(deadline)} cannot be met: {why}, {when}; "
            "name a later one, or --anyway to have it tried",
            Objection(
                field="deadline",
                value=show_deadline(deadline),
                expected=expected,
                earliest=earliest,
            ),
        )


class IdTakenError(RequestError):
    """The id belongs to another request."""

    def __init__(self, request_id: str) -> None:
        self.request_id = request_id
        super().__init__(
            Refusal.ID_TAKEN,
            f"request id {request_id!r} belongs to another request; use a new one",
            Objection(field="id", value=request_id, expected="a new id"),
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


class FingerError(TcaError):
    """A finger server cannot be asked, or answers what is no reply."""

    def __init__(self, server: str, problem: str) -> None:
        self.server, self.problem = server, problem
        super().__init__(f"the finger server {server} {problem}")
