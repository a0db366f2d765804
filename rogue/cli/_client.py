"""What the commands of users share: joining the bus for a moment, asking, reporting refusals."""

from __future__ import annotations

import contextlib
import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import TypeVar

from rogue.messages import Objection, Refusal
from tca_bus import (
    HandlerFailedError,
    Module,
    NoHandlerError,
    Query,
    TcaError,
    TimedOutError,
)
from tca_bus.cli import BusFlags, bus_options

R = TypeVar("R")

ANSWER_TIMEOUT = 20.0
"""Wall seconds that a command waits for the agent's answer."""

START_TIMEOUT = 15.0
"""Wall seconds that a command waits for an agent that should be there."""

CENTRAL = "central"
"""A module that is where an office is, and so an agent will be."""


class NotAcceptedError(TcaError):
    """The agent refused a message; its sentence says what would be right.

    ``objection`` has the facts, where the message itself is at fault.
    """

    exit_code = 2

    def __init__(self, refusal: Refusal, text: str, objection: Objection | None = None) -> None:
        self.refusal, self.objection = refusal, objection
        super().__init__(text)


class DeclinedError(NotAcceptedError):
    """Nothing is wrong with the message, but the agent will not do it unless it is told to."""

    exit_code = 7


class NotReadyError(NotAcceptedError):
    """The agent is there, but not the modules that it needs to accept a request."""

    exit_code = 3


_KINDS: dict[Refusal, type[NotAcceptedError]] = {
    Refusal.NOT_READY: NotReadyError,
    Refusal.DUPLICATE: DeclinedError,
    Refusal.TOO_LATE: DeclinedError,
}


@asynccontextmanager
async def on_bus(flags: BusFlags) -> AsyncIterator[Module]:
    """Join the bus as ``rogue-<pid>`` for as long as the block lasts."""
    async with Module(f"rogue-{os.getpid()}", options=bus_options(flags)) as module:
        yield module


async def ask(module: Module, query: Query[R]) -> R:
    """Ask the agent; where it is being started again, when it is back.

    Raises:
        NotAcceptedError: it refused.
        TcaError: it is not there, or did not answer.
    """
    try:
        return await _asked(module, query)
    except NoHandlerError:
        if CENTRAL not in module.available():
            raise
    with contextlib.suppress(TimedOutError):
        await module.wait_for(type(query), timeout=START_TIMEOUT)
    return await _asked(module, query)


async def _asked(module: Module, query: Query[R]) -> R:
    try:
        return await module.query(query, timeout=ANSWER_TIMEOUT)
    except HandlerFailedError as error:
        failure = error.failure
        if failure.name not in set(Refusal):
            raise
        refusal = Refusal(failure.name)
        objection = Objection.model_validate(failure.data) if failure.data else None
        raise _KINDS.get(refusal, NotAcceptedError)(refusal, failure.text, objection) from error
