"""What can go wrong while processes are started and kept running.

::

    TcaError
    └── LauncherError
        ├── StartFailedError    a process did not become ready
        │   └── WrongUseError   it refused the flags or files that it was given    exit 2
        ├── GaveUpError         a process crashed too often
        └── PortInUseError      somebody else listens where our router should
"""

from __future__ import annotations

import signal
from collections.abc import Sequence

from tca_bus._errors import TcaError


class LauncherError(TcaError):
    """Base of the launcher's own errors."""


class StartFailedError(LauncherError):
    """A process did not become ready; ``tail`` has the last lines that it wrote."""

    def __init__(self, process: str, why: str, tail: Sequence[str] = ()) -> None:
        self.process, self.why, self.tail = process, why, list(tail)
        super().__init__(f"{process} did not start: {why}{_quote(process, tail)}")


class WrongUseError(StartFailedError):
    """A process ended as one does that was given a wrong flag or file."""

    exit_code = 2


class GaveUpError(LauncherError):
    """A process crashed too often; ``tail`` has the last lines that it wrote."""

    def __init__(self, process: str, crashes: int, window: float, tail: Sequence[str]) -> None:
        self.process, self.crashes, self.window, self.tail = process, crashes, window, list(tail)
        super().__init__(
            f"{process} crashed {crashes} times within {window:g} s and is not started again"
            f"{_quote(process, tail)}"
        )


class PortInUseError(LauncherError):
    """Somebody else already listens at the endpoint of the router."""

    exit_code = 2

    def __init__(self, endpoint: str) -> None:
        self.endpoint = endpoint
        super().__init__(
            f"something already listens at {endpoint}: another office, perhaps. "
            "Stop it, or choose another endpoint with --connect"
        )


class NoPortError(LauncherError):
    """Every port that was tried is taken."""

    def __init__(self, host: str, tries: int) -> None:
        self.host, self.tries = host, tries
        super().__init__(f"{tries} ports of {host} that were tried are taken")


def describe_exit(code: int) -> str:
    """Say how a process ended; ``code`` is negative for a signal, as in `subprocess`."""
    if code >= 0:
        return f"ended with exit code {code}"
    try:
        return f"was killed by {signal.Signals(-code).name}"
    except ValueError:
        return f"was killed by signal {-code}"


def _quote(process: str, tail: Sequence[str]) -> str:
    if not tail:
        return f"; {process} wrote nothing"
    lines = "\n".join(f"    {line}" for line in tail)
    return f"; the last that {process} wrote:\n{lines}"
