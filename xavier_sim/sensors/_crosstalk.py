"""Sonars that take a neighbour's ping for their own."""

from __future__ import annotations

from typing import Any

import numpy as np

from xavier_sim.noise import restore_stream, stream, stream_state
from xavier_sim.sensors._caster import Floats


class Crosstalk:
    """Lets each sonar hear, now and then, what its neighbour sent out at the same moment.

    The foreign ping has gone from the neighbour to where it met something and from there to the
    listener. That takes the time of an echo from half as far, and the first ping counts.

    Args:
        share: of the neighbour's pings that are heard, 0 to 1.
        seed: of what is heard when.
    """

    def __init__(self, share: float, seed: int) -> None:
        self._share = share
        self._random = stream(seed, "sonar crosstalk")

    def draw(self, sonars: int) -> Floats | None:
        """Draw who of so many sonars hears a neighbour, for `disturb`; None when nobody does."""
        draw = self._random.random(sonars)
        return draw if min(draw.tolist(), default=1.0) < self._share else None

    def disturb(
        self, draw: Floats, mounts: Floats, bearing: Floats, echoes: list[float]
    ) -> list[float]:
        """What each of k sonars hears first, metres, ``inf`` for nothing.

        Args:
            draw: who hears a neighbour.
            mounts: of the sonars that fire together, in their order round the ring, metres,
                shape (k, 2).
            bearing: where each one's echo comes from, radians, shape (k,).
            echoes: how far that is, metres.
        """
        hears, echo = draw < self._share, np.array(echoes)
        met = np.isfinite(echo)
        away = np.where(met, echo, 0.0)
        spots = mounts + away[:, None] * np.column_stack([np.cos(bearing), np.sin(bearing)])
        sender = np.where(draw < self._share / 2, -1, 1) + np.arange(len(echo))
        sender %= len(echo)
        back = np.hypot(*(spots[sender] - mounts).T)
        foreign = np.where(met[sender], (echo[sender] + back) / 2, np.inf)
        first: list[float] = np.where(hears, np.minimum(echo, foreign), echo).tolist()
        return first

    def snapshot(self) -> dict[str, Any]:
        """What `restore` needs."""
        return {"random": stream_state(self._random)}

    def restore(self, state: dict[str, Any]) -> None:
        """Go back to a snapshot."""
        restore_stream(self._random, state["random"])
