"""The asking side of pools: standing in the lines of all modules that are busy."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TYPE_CHECKING

from tca_bus._errors import NoHandlerError, TcaError
from tca_bus._presence import PresentModule
from tca_bus._turns import AwaitTurn
from tca_bus._wire import Payload, encode_message

if TYPE_CHECKING:
    from tca_bus._caller import Caller

Providers = Callable[[], list[PresentModule]]


class PoolWait:
    """One request that waits for the first of several modules to have a place for it.

    Modules that come meanwhile are waited for too; ``first`` ends when all have refused or are
    gone, with the error of the last.
    """

    def __init__(self, caller: Caller, name: str, request: str, providers: Providers) -> None:
        self._caller = caller
        self._name = name
        self._request = request
        self._providers = providers
        self._turns: dict[asyncio.Task[Payload], PresentModule] = {}
        self._asked: set[str] = set()
        self._error: TcaError | None = None

    async def first(self) -> PresentModule:
        """The module that keeps a place for the request."""
        try:
            while True:
                self._ask_those_that_are_new()
                if not self._turns:
                    raise self._error or NoHandlerError(self._name)
                winner = await self._next_turn()
                if winner is not None:
                    return winner
        finally:
            await self._leave_the_others()

    def _ask_those_that_are_new(self) -> None:
        for module in self._providers():
            if module.incarnation not in self._asked:
                self._asked.add(module.incarnation)
                waiting = self._caller.ask_callee(
                    module,
                    AwaitTurn.wire_name,
                    encode_message(AwaitTurn(message=self._name, request=self._request)),
                )
                name = f"{self._caller.core.name}.turn.{module.name}"
                self._turns[asyncio.create_task(waiting, name=name)] = module

    async def _next_turn(self) -> PresentModule | None:
        """Wait for a turn, a refusal or a change of who is there; gives who has a place."""
        bell = asyncio.create_task(self._caller.core.presence.changed(), name="presence")
        try:
            await asyncio.wait([bell, *self._turns], return_when=asyncio.FIRST_COMPLETED)
        finally:
            bell.cancel()
        for turn in [turn for turn in self._turns if turn.done()]:
            error = turn.exception()
            if error is None:
                return self._turns.pop(turn)
            if not isinstance(error, TcaError):
                raise error
            self._error = error
            del self._turns[turn]
        return None

    async def _leave_the_others(self) -> None:
        for turn, module in self._turns.items():
            turn.cancel()
            self._caller.withdraw(module, self._name, self._request)
        await asyncio.gather(*self._turns, return_exceptions=True)
