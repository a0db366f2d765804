"""Queries to all modules that handle a message."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from typing import Any, TypeVar

from tca_bus._caller import Caller
from tca_bus._errors import NoHandlerError, TcaError
from tca_bus._messages import MultiQuery
from tca_bus._presence import PresentModule
from tca_bus._types import answer_adapter
from tca_bus._wire import decode_answer, encode_message

R = TypeVar("R")


async def ask_all(caller: Caller, message: MultiQuery[R], timeout: float) -> AsyncIterator[R]:
    """Ask every provider at once and give the answers as they come.

    Raises:
        NoHandlerError: There is no provider.
        ExceptionGroup: After all answers: what those who gave none failed with.
    """
    table = caller.core.presence.table
    providers = table.providers(message.wire_name)
    if not providers:
        raise NoHandlerError(message.wire_name, table.known_messages())
    asked = [asyncio.ensure_future(_ask(caller, message, one, timeout)) for one in providers]
    errors: list[TcaError] = []
    try:
        for answer in asyncio.as_completed(asked):
            try:
                value = await answer
            except TcaError as error:
                errors.append(error)
            else:
                yield value
    finally:
        for question in asked:
            question.cancel()
        await asyncio.gather(*asked, return_exceptions=True)
    if errors:
        raise ExceptionGroup(f"not all answered {message.wire_name!r}", errors)


async def _ask(caller: Caller, message: MultiQuery[Any], to: PresentModule, timeout: float) -> Any:
    kind = type(message)
    payload = encode_message(message)
    answer = await caller.call(kind.wire_name, payload, to=to, timeout=timeout)
    return decode_answer(answer, answer_adapter(kind), kind.wire_name)
