"""Taking back a request, decided in one transaction with what is known of the world."""

from __future__ import annotations

from collections.abc import Callable

from rogue.memory._database import Database
from rogue.memory._facts import Facts, KeptFacts
from rogue.memory._requests import KeptRequests, write_change
from rogue.memory._steps import KeptSteps, Step
from rogue.messages import DeliveryRequest

Decide = Callable[[DeliveryRequest, Facts, Step | None], DeliveryRequest]
"""What becomes of an open request, told what is known and which step is being carried out."""


class Withdrawals(KeptRequests, KeptFacts, KeptSteps):
    """The part of the store in which requests are taken back."""

    _base: Database

    async def withdraw(self, request_id: str, decide: Decide) -> DeliveryRequest | None:
        """Change an open request as ``decide`` says; None when it has ended already.

        No step begins or ends between what ``decide`` is told and what it decides.
        """
        async with self._base.transaction() as link:
            request = await self.request(request_id)
            if request is None or request.state.is_final:
                return None
            changed = decide(request, await self.facts(), await self.open_step())
            closing = changed.closing
            if closing is not None:
                values = (changed.then, closing.model_dump_json(), request_id)
                sql = 'UPDATE requests SET "then" = ?, closing = ? WHERE id = ?'
                await link.execute(sql, values)
            note = changed.reason or (closing.reason if closing else None)
            await write_change(link, changed, note)
            return changed
