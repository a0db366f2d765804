"""Central's desk for shared variables: decides each change, journals it, then publishes it."""

from __future__ import annotations

import asyncio
import time
from dataclasses import dataclass, field
from functools import partial

import aiosqlite

from tca_bus._context import Context
from tca_bus._journal import Journal
from tca_bus._module import Module
from tca_bus._tasks import CENTRAL
from tca_bus._variable_store import load_variables, save_changes
from tca_bus._variables import (
    GetVariable,
    ListVariables,
    SetVariable,
    VariableChange,
    VariableState,
    VariableTable,
)
from tca_bus._wire import Payload

VARIABLE_ENCODING = "application/json;tca.variable@1"


@dataclass(slots=True)
class _Write:
    """A change that is decided and not yet in the journal, and who waits for it."""

    order: SetVariable
    change: VariableChange
    done: asyncio.Future[None] = field(
        default_factory=lambda: asyncio.get_running_loop().create_future()
    )


class VariableDesk:
    """The handlers of messages about variables, and the writer behind them.

    Nothing is told that is not in the journal: an answer and a publication come after the commit
    of what they say.
    """

    def __init__(self, module: Module, journal: Journal) -> None:
        self._module = module
        self._journal = journal
        self._table = VariableTable()
        self._writes: list[_Write] = []
        self._wake = asyncio.Event()
        self._ready = asyncio.Event()

    def serve(self) -> None:
        """Register the handlers."""
        self._module.serve(SetVariable, self.change)
        self._module.serve(GetVariable, self.find)
        self._module.serve(ListVariables, self.everything)

    async def begin(self) -> None:
        """Load what the journal has, publish it, and begin to answer.

        Raises:
            JournalError: What it has cannot be read.
        """
        self._table = await self._journal.transact(load_variables)
        self._module.start(self._write_changes(), name=f"{CENTRAL}.variables")
        self._module.serve_states(self._module.keys.variable("*"), self._lookup)
        # What is set while central's own link is down is published when it is up again.
        self._module.on_return(self._publish_all)
        self._publish_all()
        self._ready.set()

    async def change(self, order: SetVariable, context: Context) -> VariableChange:
        """Set a variable, or say again what the same change did before."""
        await self._ready.wait()
        change = self._table.made(order.change)
        if change is None:
            change = self._table.apply(order, writer=context.sender, now=time.time())
            self._enqueue(_Write(order, change))
        await self._committed()
        return change

    async def find(self, question: GetVariable, _: Context) -> VariableState:
        """The state of a variable."""
        await self._ready.wait()
        state = self._table.get(question.name)
        await self._committed()
        return state

    async def everything(self, _question: ListVariables, _context: Context) -> list[VariableState]:
        """All variables."""
        await self._ready.wait()
        states = self._table.all()
        await self._committed()
        return states

    async def _committed(self) -> None:
        """Wait until all that was decided so far is in the journal."""
        if self._writes:
            await asyncio.shield(self._writes[-1].done)

    def _enqueue(self, write: _Write) -> None:
        self._writes.append(write)
        self._wake.set()

    async def _write_changes(self) -> None:
        """Write all that came since the last commit in one transaction, then publish it."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            batch = list(self._writes)
            await self._journal.transact(partial(self._save, batch))
            del self._writes[: len(batch)]
            for write in batch:
                self._publish(write.change.after)
                write.done.set_result(None)

    async def _save(self, batch: list[_Write], database: aiosqlite.Connection) -> None:
        changes = [(write.order.change, write.change) for write in batch]
        await save_changes(database, changes, self._table.schema)

    def _publish(self, state: VariableState) -> None:
        self._module.publish_state(self._module.keys.variable(state.name), _payload(state))

    def _publish_all(self) -> None:
        for state in self._known():
            self._publish(state)

    def _known(self) -> list[VariableState]:
        """The states that are in the journal."""
        pending: dict[str, VariableState | None] = {}
        for write in self._writes:
            pending.setdefault(write.order.name, write.change.before)
        states = (pending.get(state.name, state) for state in self._table.all())
        return [state for state in states if state is not None]

    def _lookup(self, key: str) -> list[tuple[str, Payload]]:
        del key
        return [(self._module.keys.variable(s.name), _payload(s)) for s in self._known()]


def _payload(state: VariableState) -> Payload:
    return Payload(state.model_dump_json().encode(), VARIABLE_ENCODING)
