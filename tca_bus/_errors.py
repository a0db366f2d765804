"""What can go wrong on the bus.

::

    TcaError
    ├── ConfigError            an option is wrong                      exit 2
    ├── InvalidMessageError    a payload does not fit its message      exit 2
    ├── NoHandlerError         nobody here handles the message         exit 3
    ├── TimedOutError          no answer in time                       exit 4
    ├── BusGoneError           no router, or it went away              exit 5
    ├── ClosedError            this module was closed by its owner     exit 6
    ├── KilledError            the task was killed or cancelled        exit 6
    ├── RefusedError           the other side may not or will not      exit 7
    │   ├── BusyError          it has too much waiting to take more    exit 7
    │   │   ├── AtCapacityError    the handler has no place free now   exit 7
    │   │   └── PendingLimitError  later ones took its turn            exit 7
    │   └── DeadlockError      it would wait for itself                exit 7
    ├── LeaseLostError         a resource was taken from its holder    exit 1
    ├── PeerLostError          the module that had it died             exit 1
    ├── NeverSetError          a shared variable has no value yet      exit 1
    ├── VariableChangedError   it is not as the setter expected        exit 1
    ├── HandlerFailedError     the handler of a query raised           exit 1
    └── TaskFailedError        a goal or command failed                exit 1

`TaskError` is not in the tree: it is what a *handler* raises to fail with a name and data.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from typing import Any, ClassVar

from pydantic import BaseModel

from tca_bus._failure import Failure
from tca_bus._messages import TcaException
from tca_bus._types import summary

LONGEST_NAME = 100
"""Letters of a name that count when near matches are looked for: what arrives may be endless."""

MOST_LISTED = 20
"""How many names an error lists at most."""


def near_matches(word: str, known: Iterable[str], *, most: int = 3) -> list[str]:
    """The names in ``known`` that look most like ``word``, the nearest first."""
    by_lower = {name.lower(): name for name in known}
    hits = difflib.get_close_matches(word[:LONGEST_NAME].lower(), by_lower, n=most, cutoff=0.5)
    return [by_lower[hit] for hit in hits]


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """A sentence with near matches, to append to an error; empty when nothing is near."""
    hits = near_matches(word, known)
    return f" Did you mean {' or '.join(repr(hit) for hit in hits)}?" if hits else ""


def near_or_all(word: str, known: Iterable[str]) -> str:
    """What would be right instead of ``word``, as a sentence to append to an error.

    Near matches if there are any, else all names, or the first and the last of many.
    """
    names = sorted(known)
    if hint := did_you_mean(word, names):
        return hint
    if len(names) > MOST_LISTED:
        return f" There are {len(names)}, from {names[0]!r} to {names[-1]!r}."
    return f" There are: {', '.join(names)}." if names else ""


class TcaError(Exception):
    """Base of all errors of `tca_bus`. ``exit_code`` is what command lines end with."""

    exit_code: ClassVar[int] = 1

    def __reduce__(self) -> tuple[Any, ...]:
        """Cross processes with all facts: an error is not made anew from the sentence it built."""
        return _as_it_was, (type(self), self.args), self.__dict__


def _as_it_was(kind: type[TcaError], args: tuple[object, ...]) -> TcaError:
    error = kind.__new__(kind)
    error.args = args
    return error


class ConfigError(TcaError, ValueError):
    """An option has a value that cannot be used."""

    exit_code = 2

    def __init__(self, option: str, value: object, expected: str) -> None:
        self.option, self.value, self.expected = option, value, expected
        super().__init__(f"{option} is {value!r}, expected {expected}")


class InvalidMessageError(TcaError, ValueError):
    """A payload does not fit its message type."""

    exit_code = 2

    def __init__(self, message: str, problems: list[str]) -> None:
        self.message, self.problems = message, problems
        super().__init__(f"this is no valid {message!r}: {'; '.join(problems)}")


class NoHandlerError(TcaError, LookupError):
    """No module on the bus handles the message."""

    exit_code = 3

    def __init__(self, message: str, known: Iterable[str] = ()) -> None:
        self.message = message
        others = [name for name in known if name != message]
        self.near = near_matches(message, others)
        hint = did_you_mean(message, others) or " 'tca modules' lists who is there."
        super().__init__(f"no module handles {message!r}.{hint}")


class TimedOutError(TcaError, TimeoutError):
    """No answer came in time; the other side may still be at it."""

    exit_code = 4

    def __init__(self, what: str, seconds: float) -> None:
        self.what, self.seconds = what, seconds
        super().__init__(f"{what}: no answer within {seconds:g} s")


class BusGoneError(TcaError, ConnectionError):
    """The router cannot be reached."""

    exit_code = 5

    def __init__(self, endpoint: str, why: str = "") -> None:
        self.endpoint, self.why = endpoint, why
        reason = f" ({why})" if why else ""
        super().__init__(
            f"no router at {endpoint}{reason}. Start one with 'tca router' or 'rogue up', "
            "or name another with --connect"
        )


class ClosedError(TcaError):
    """The module was closed by its owner; nothing more can be sent from it."""

    exit_code = 6

    def __init__(self, module: str) -> None:
        self.module = module
        super().__init__(f"module {module!r} is closed")


class KilledError(TcaError):
    """The task was killed or cancelled before it ended by itself."""

    exit_code = 6

    def __init__(self, task: str, reason: str) -> None:
        self.task, self.reason = task, reason
        super().__init__(f"task {task} was killed: {reason}")


class RefusedError(TcaError, PermissionError):
    """The other side may not or will not do it."""

    exit_code = 7

    def __init__(self, what: str, why: str) -> None:
        self.what, self.why = what, why
        super().__init__(f"{what} was refused: {why}")


class BusyError(RefusedError):
    """The other side has too much waiting to take more; it may be asked again."""


class AtCapacityError(BusyError):
    """All places of a handler are taken; the caller may wait for its turn, and modules do."""


class PendingLimitError(BusyError):
    """More than may waited for a resource, and this was the oldest of them."""


def ring_words(members: list[str]) -> str:
    """Those that wait for each other, as a sentence."""
    return " waits for ".join([*members, *members[:1]])


class DeadlockError(RefusedError):
    """Waiting for it would never end: whoever has it waits, in the end, for the asker.

    ``members`` are those that would wait for each other, in order.
    """

    def __init__(self, what: str, members: list[str]) -> None:
        self.members = list(members)
        super().__init__(what, f"it would wait for itself: {ring_words(self.members)}")


class LeaseLostError(TcaError):
    """A resource was taken from its holder: unlocked by hand, or its module was taken for lost."""

    def __init__(self, names: Iterable[str], why: str) -> None:
        self.names, self.why = tuple(names), why
        super().__init__(f"{', '.join(self.names)} is held no more: {why}")


class PeerLostError(TcaError, ConnectionError):
    """The module that worked on it died before it answered."""

    def __init__(self, module: str, what: str) -> None:
        self.module, self.what = module, what
        super().__init__(f"module {module!r} was lost while it handled {what!r}")


class NeverSetError(TcaError, LookupError):
    """A shared variable was never set."""

    def __init__(self, name: str, known: Iterable[str] = ()) -> None:
        self.name = name
        others = [other for other in known if other != name]
        self.near = near_matches(name, others)
        super().__init__(f"variable {name!r} was never set.{did_you_mean(name, others)}")


class VariableChangedError(TcaError):
    """A shared variable is not at the sequence number that its setter expected."""

    def __init__(self, name: str, expected: int, found: int) -> None:
        self.name, self.expected, self.found = name, expected, found
        super().__init__(
            f"variable {name!r} was not set: expected sequence {_sequence(expected)}, "
            f"found {_sequence(found)}"
        )


class HandlerFailedError(TcaError):
    """The handler of a query or inform raised."""

    def __init__(self, failure: Failure) -> None:
        self.failure = failure
        super().__init__(failure.sentence())


class TaskFailedError(TcaError):
    """A goal or a command failed; ``failure`` says why, with the chain of causes."""

    def __init__(self, task: str, failure: Failure) -> None:
        self.task, self.failure = task, failure
        super().__init__(failure.sentence())


def _sequence(number: int) -> str:
    return str(number) if number else "0 (never set)"


class TaskError(Exception):
    """Raised by a handler: it failed, for a reason that has a name and may have data.

    ``reason`` is a name, or a `TcaException`, which brings name and data along and is caught by
    handlers of its base classes too.
    """

    def __init__(
        self,
        reason: str | TcaException,
        text: str = "",
        *,
        data: BaseModel | dict[str, Any] | None = None,
    ) -> None:
        if isinstance(reason, TcaException):
            self.name, self.kinds, data = reason.wire_name, reason.kinds(), data or reason
            text = text or summary(type(reason)) or self.name
        else:
            self.name, self.kinds = reason, ()
        self.text = text or self.name
        self.data = data.model_dump(mode="json") if isinstance(data, BaseModel) else data
        super().__init__(self.text)
