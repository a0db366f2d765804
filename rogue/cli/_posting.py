"""Posting a request, and finding out what nobody but the user knows."""

from __future__ import annotations

import asyncio
import sys

from rogue.absence import POST_PATIENCE, persist
from rogue.cli._client import NotAcceptedError, ask
from rogue.messages import DeliveryRequest, PostRequest, Refusal
from tca_bus import Module
from tca_bus.cli import note

ANSWER_PATIENCE = 300.0
"""Wall seconds for which a request is posted again while its user is being asked."""


async def post(module: Module, message: PostRequest) -> DeliveryRequest:
    """Post a request; ask for a room that nobody knows, in the terminal if there is one.

    Without a terminal the agent asks on the robot's keyboard.

    Raises:
        NotAcceptedError: it was refused, or there is no answer.
        TcaError: the agent is not there, or did not answer.
    """
    while True:
        patience = ANSWER_PATIENCE if message.ask else POST_PATIENCE
        sent = message
        try:
            return await persist(lambda: ask(module, sent), patience)  # noqa: B023 - called here
        except NotAcceptedError as error:
            if error.refusal is not Refusal.MISSING_ROOM or message.ask:
                raise
            message = await _more(message, error)


async def _more(message: PostRequest, error: NotAcceptedError) -> PostRequest:
    """The message with the room in it that was missing, or with leave to ask for it."""
    objection = error.objection
    if objection is None or objection.question is None:
        raise error
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        note(f"On the robot's keyboard, {message.user} is asked: {objection.question}")
        return message.model_copy(update={"ask": True})
    answer = await _typed(objection.question)
    if not answer:
        raise error
    return message.model_copy(update={objection.field: answer})


async def _typed(question: str) -> str:
    """A line that is typed in answer to a question; waiting for it can be cancelled."""
    loop = asyncio.get_running_loop()
    ready = asyncio.Event()
    sys.stderr.write(f"{question} ")
    sys.stderr.flush()
    loop.add_reader(sys.stdin.fileno(), ready.set)
    try:
        await ready.wait()
    finally:
        loop.remove_reader(sys.stdin.fileno())
    return sys.stdin.readline().strip()
