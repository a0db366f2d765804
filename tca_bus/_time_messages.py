"""How simulated time goes over the bus: who makes it, and who waits for it."""

from __future__ import annotations

from pydantic import Field, FiniteFloat

from tca_bus._messages import Broadcast

TIME_GRAIN = 1e-6
"""Simulated times nearer to each other than this, in seconds, are the same."""


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

    In lockstep time does not go past that before the module has said what it waits for next;
    with a time that has come already it says that time is to stand still for it. ``moves`` tells
    whether it waits actively: at full speed simulated time moves only for those who do. Repeated
    every wall second.
    """

    wire_name = "tca.awaitTime"

    module: str
    incarnation: str
    until: FiniteFloat | None
    moves: bool = True


class Settle(Broadcast):
    """The module that makes simulated time asks whether all have taken what was told them.

    In lockstep it does so after whatever may set others to work, and time does not go on before
    everybody who follows it has answered with this ``number``.
    """

    wire_name = "tca.settle"

    number: int = Field(ge=1)


class Settled(Broadcast):
    """A module that follows simulated time has taken what came before the `Settle` of a number.

    Whoever it has to make time stand still for has said so by then. With 0 it says no more than
    that it follows the time.
    """

    wire_name = "tca.settled"

    module: str
    incarnation: str
    number: int = Field(ge=0)
