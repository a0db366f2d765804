"""Limits to size and rate, checked by the sender: what a router drops it drops without a word."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from tca_bus._errors import RefusedError
from tca_bus._policy import Limit

MOST_MESSAGE_BYTES = 16 * 1024 * 1024
"""Bigger messages vanish at the router; the link stays up."""

ENVELOPE_BYTES = 4096
"""What an attachment and the frame of a task may add to a message, at the most."""


LARGEST_PAYLOAD = MOST_MESSAGE_BYTES - ENVELOPE_BYTES
"""Bytes of the biggest payload that passes a router."""


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
        rates = {p: limit.hertz for p, limit in limits.items() if limit.hertz is not None}
        if rates:
            now = self.now()
            for pattern, hertz in rates.items():
                self._check_rate(name, pattern, hertz, now)
            self._last.update(dict.fromkeys(rates, now))

    def _check_rate(self, name: str, pattern: str, hertz: float, now: float) -> None:
        since = now - self._last.get(pattern, -math.inf)
        if since < 1.0 / hertz:
            why = (
                f"it comes {since:.3g} s after the one before, and the policy allows "
                f"{hertz:g} per second (limits.{pattern})"
            )
            raise RefusedError(f"sending {name!r}", why)


def check_size(name: str, size: int, limits: dict[str, Limit]) -> None:
    """Refuse a payload that has too many bytes.

    Raises:
        RefusedError: It says how many it has and how many it may have.
    """
    if size > LARGEST_PAYLOAD:
        why = f"it has {size} bytes, and routers take {LARGEST_PAYLOAD}"
        raise RefusedError(f"sending {name!r}", why)
    for pattern, limit in limits.items():
        if limit.bytes is not None and size > limit.bytes:
            allowed = f"the policy allows {limit.bytes} (limits.{pattern})"
            raise RefusedError(f"sending {name!r}", f"it has {size} bytes, and {allowed}")
