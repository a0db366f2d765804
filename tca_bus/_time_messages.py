"""How simulated time goes over the bus: who makes it, and who waits for it."""

from __future__ import annotations

from pydantic import FiniteFloat

from tca_bus._messages import Broadcast


class SimulatedTime(Broadcast):
    """The simulated time, from the module that makes it.

    ``time`` is seconds since the epoch, ``speed`` simulated seconds per wall second, None for
    lockstep.
    """

    wire_name = "tca.simTime"

    time: FiniteFloat
    speed: FiniteFloat | None


class AwaitTime(Broadcast):
    """A module waits on simulated time until ``until``; None when it waits no more.

    At full speed simulated time moves only for those who wait. Repeated every wall second.
    """

    wire_name = "tca.awaitTime"

    module: str
    incarnation: str
    until: FiniteFloat | None
