"""The modules of a chaos run: ``python chaos_crew.py NAME LEDGER``, told of the bus by TCA_..."""

from __future__ import annotations

import asyncio
import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

from chaos_ledger import Deed, Ledger
from chaos_plan import POLICIES
from pydantic import BaseModel

from tca_bus import BusOptions, Command, Goal, Module, TaskContext, TaskError, TaskFailedError

DROPPED = "dropped"
"""The failure of a task that is planned to fail."""

PATIENCE = 120.0
"""Wall seconds to wait for a handler or an acknowledgement while others are killed."""


class Effect(BaseModel):
    """Who brought a command to its end, and at which attempt."""

    module: str
    attempt: int


class Lift(Command[Effect]):
    """Work for a while, then succeed or fail."""

    work: float
    fails: bool


class Fetch(Goal[int]):
    """Make ``children`` commands, the last of which may fail; gives how many succeeded."""

    work: float
    fails: bool
    children: int
    child_policy: str
    lenient: bool


def under(message_type, policy):
    """The message type with a policy of its own for the loss of its module."""
    names = {"wire_name": f"{message_type.wire_name}.{policy}", "on_module_lost": policy}
    return type(message_type.__name__, (message_type,), {"__module__": __name__, **names})


LIFT = {policy: under(Lift, policy) for policy in POLICIES}
FETCH = {policy: under(Fetch, policy) for policy in POLICIES}


class Crew:
    """The handlers of one module; each deed is noted before anything else can learn of it."""

    def __init__(self, module: Module, ledger: Ledger) -> None:
        self.module = module
        self.ledger = ledger
        for policy in POLICIES:
            module.serve(LIFT[policy], self.lift, capacity=2)
            module.serve(FETCH[policy], self.fetch, capacity=2)

    async def lift(self, message, context):
        with self._noted(context):
            await asyncio.sleep(message.work)
            if message.fails:
                raise TaskError(DROPPED, f"{context.id} is planned to fail")
        return Effect(module=self.module.name, attempt=context.attempt)

    async def fetch(self, message, context):
        with self._noted(context):
            children = [
                await self._child(message, context, number) for number in range(message.children)
            ]
            succeeded = 0
            for child in children:
                with contextlib.suppress(*(TaskFailedError,) if message.lenient else ()):
                    await child.result()
                    succeeded += 1
        return succeeded

    async def _child(self, message, context, number):
        fails = message.fails and number == message.children - 1
        return await context.execute(
            LIFT[message.child_policy](work=message.work / message.children, fails=fails),
            id=f"{context.id}.{context.attempt}.{number}",
            wait_for_handler=PATIENCE,
            timeout=PATIENCE,
        )

    @contextlib.contextmanager
    def _noted(self, context: TaskContext) -> Iterator[None]:
        def note(deed: Deed) -> None:
            self.ledger.note(deed, context.id, context.attempt, self.module.name)

        note(Deed.BEGUN)
        try:
            yield
        except asyncio.CancelledError:
            note(Deed.STOPPED)
            raise
        except Exception:
            note(Deed.FAILED)
            raise
        note(Deed.DONE)


async def main(name: str, ledger: str) -> None:
    options = BusOptions(connect=os.environ["TCA_CONNECT"], realm=os.environ["TCA_REALM"])
    module = Module(name, options=options)
    Crew(module, Ledger(Path(ledger)))
    async with module:
        await module.serve_forever()


if __name__ == "__main__":
    asyncio.run(main(*sys.argv[1:]))
