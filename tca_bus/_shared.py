"""Shared variables as a module uses them."""

from __future__ import annotations

import secrets
from typing import TypeVar

from tca_bus._lifecycle import Lifecycle
from tca_bus._variable_watch import VariableWatch, reading_of
from tca_bus._variables import (
    GetVariable,
    ListVariables,
    Reading,
    SetVariable,
    Variable,
    VariableChange,
    VariableState,
)
from tca_bus._wire import build

T = TypeVar("T")


class SharedVariables(Lifecycle):
    """Sets, reads and watches variables that central keeps.

    A change that was acknowledged is in central's journal. Each is made once, however often it
    had to be sent.

    Raises:
        InvalidMessageError: From any method, a value is not of the variable's type; the error
            says what was expected.
        NoHandlerError: From any method, there is no central.
        TimedOutError: From any method, central did not answer within ``timeout`` wall seconds;
            a change may have been made.
        BusGoneError: From any method, the router was away for the rest of that time.
    """

    async def set(
        self,
        variable: Variable[T],
        value: T,
        *,
        expected: int | None = None,
        redefine: bool = False,
        timeout: float = 10.0,
    ) -> int:
        """Set a variable; gives the sequence number of the new value.

        With ``expected`` it is compare-and-set: the value is set only if the variable is at that
        sequence number, 0 for one that was never set. With ``redefine`` the type may change.

        Raises:
            VariableChangedError: It is at another sequence number.
        """
        change = await self._change(variable, value, expected, redefine, timeout)
        return change.after.sequence

    async def get(self, variable: Variable[T], *, timeout: float = 10.0) -> T:
        """The value of a variable.

        Raises:
            NeverSetError: It has none yet.
        """
        return (await self.read(variable, timeout=timeout)).value

    async def read(self, variable: Variable[T], *, timeout: float = 10.0) -> Reading[T]:
        """The value of a variable with its sequence number, writer and time.

        Raises:
            NeverSetError: It has none yet.
        """
        question = GetVariable(name=variable.name)
        state = await self._parts.sender.ask_central(question, timeout=timeout)
        return reading_of(variable, state)

    async def swap(
        self,
        variable: Variable[T],
        value: T,
        *,
        expected: int | None = None,
        timeout: float = 10.0,
    ) -> T | None:
        """Set a variable and give the value that it had, in one step; None if it had none.

        Raises:
            VariableChangedError: It is not at the sequence number ``expected``.
        """
        change = await self._change(variable, value, expected, False, timeout)
        return None if change.before is None else variable.decode(change.before.value)

    def watch(self, variable: Variable[T]) -> VariableWatch[T]:
        """Follow a variable: its value now, and each later one that is still the latest."""
        return VariableWatch(lambda: self._parts, variable)

    async def variables(self, *, timeout: float = 10.0) -> list[VariableState]:
        """All variables that were ever set, by name."""
        return await self._parts.sender.ask_central(ListVariables(), timeout=timeout)

    async def _change(
        self,
        variable: Variable[T],
        value: T,
        expected: int | None,
        redefine: bool,
        timeout: float,
    ) -> VariableChange:
        order = build(
            SetVariable,
            name=variable.name,
            value=variable.encode(value),
            change=f"{self.name}-{secrets.token_hex(10)}",
            expected=expected,
            value_schema=variable.schema(),
            redefine=redefine,
        )
        return await self._parts.sender.ask_central(order, timeout=timeout)
