"""Limits to size and rate, checked by the sender: what a router drops it drops without a word."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from tca_bus._errors import RefusedError
from tca_bus._policy import Limit

MOST_MESSAGE_BYTES = 16 * 1024 * 1024
"""Bigger messages vanish at the router; the link stays up."""

ENVELOPE_BYTES = 4096
"""What an attachment and the frame of a task may add to a message, at the most."""


@dataclass
class Meter:
    """Holds the messages of one module to their limits; ``now`` gives monotonic seconds."""

    now: Callable[[], float]
    _last: dict[str, float] = field(default_factory=dict)

    def check(self, name: str, size: int, limits: dict[str, Limit]) -> None:
        """Refuse a message that is too big or comes too soon after the one before.

        Args:
            name: The wire name of the message.
            size: Bytes of its payload.
            limits: Those that it has to keep, by their patterns in the policy.

        Raises:
            RefusedError: It says by how much.
        """
        check_size(name, size, limits)
        for pattern, limit in limits.items():
            self._check_rate(name, pattern, limit)
        now = self.now()
        self._last.update({p: now for p, limit in limits.items() if limit.hertz is not None})

    def _check_rate(self, name: str, pattern: str, limit: Limit) -> None:
        last = self._last.get(pattern)
        if limit.hertz is None or last is None:
            return
        since = self.now() - last
        if since < 1.0 / limit.hertz:
            why = (
                f"it comes {since:.3g} s after the one before, and the policy allows "
                f"{limit.hertz:g} per second (limits.{pattern})"
            )
            raise RefusedError(f"sending {name!r}", why)


def check_size(name: str, size: int, limits: dict[str, Limit]) -> None:
    """Refuse a payload that has too many bytes.

    Raises:
        RefusedError: It says how many it has and how many it may have.
    """
    if size > MOST_MESSAGE_BYTES - ENVELOPE_BYTES:
        most = MOST_MESSAGE_BYTES - ENVELOPE_BYTES
        raise RefusedError(f"sending {name!r}", f"it has {size} bytes, and routers take {most}")
    for pattern, limit in limits.items():
        if limit.bytes is not None and size > limit.bytes:
            allowed = f"the policy allows {limit.bytes} (limits.{pattern})"
            raise RefusedError(f"sending {name!r}", f"it has {size} bytes, and {allowed}")
