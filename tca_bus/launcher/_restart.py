"""When to start a crashed process again: pure, told the time by its caller."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, fields

from tca_bus._errors import ConfigError


@dataclass(frozen=True, kw_only=True)
class RestartPolicy:
    """Exponential backoff with a limit; all times in seconds.

    Attributes:
        first_delay: Wait before the first restart.
        factor: By how much each further wait is longer.
        longest_delay: No wait is longer than this.
        calm_after: A process that ran this long begins again at ``first_delay``.
        most: Crashes allowed within ``window``; one more and it is given up.
        window: Length of the sliding window in which crashes count.
    """

    first_delay: float = 0.2
    factor: float = 2.0
    longest_delay: float = 10.0
    calm_after: float = 10.0
    most: int = 10
    window: float = 60.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            least = 1 if field.name == "factor" else 0
            if not value >= least:
                raise ConfigError(f"RestartPolicy.{field.name}", value, f"{least} or more")


DEFAULT_POLICY = RestartPolicy()
"""How a process is treated whose spec says nothing about it."""


class RestartHistory:
    """The crashes of one process so far, and what follows from each."""

    def __init__(self, policy: RestartPolicy) -> None:
        self.policy = policy
        self._crashes: deque[float] = deque()
        self._delay = policy.first_delay

    @property
    def crashes(self) -> int:
        """Crashes within the window that ended with the last one."""
        return len(self._crashes)

    def crashed(self, *, now: float, ran_for: float) -> float | None:
        """Take note of a crash.

        Args:
            now: Time of the crash on any steady clock.
            ran_for: For how long the process had run.

        Returns:
            Seconds to wait before the next start; None when it is to be given up.
        """
        policy = self.policy
        self._crashes.append(now)
        while self._crashes[0] < now - policy.window:
            self._crashes.popleft()
        if len(self._crashes) > policy.most:
            return None
        if ran_for >= policy.calm_after:
            self._delay = policy.first_delay
        delay = min(self._delay, policy.longest_delay)
        self._delay = min(self._delay * policy.factor, policy.longest_delay)
        return delay
