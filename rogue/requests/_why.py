"""Why a request stands where it does, from all that is kept of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

from rogue.explain import Record, story, told
from rogue.memory import Store
from rogue.messages import DeliveryRequest, WhyEntry, WhyReport


async def why_report(
    store: Store,
    request: DeliveryRequest,
    others: Sequence[DeliveryRequest],
    now: float,
    *,
    everything: bool = False,
) -> WhyReport:
    """The story of a request, with all open requests and the time at which it is told.

    With ``everything`` it has the planner's routine choices too.
    """
    held = [hold for hold in await store.holds() if hold.request == request.id]
    waiting = [(hold.until, hold.reason) for hold in held if now < hold.until]
    record = Record(
        request=request,
        filled=await store.filled(request.id),
        decisions=await store.decisions(request.id),
        forgotten=await store.forgotten(request.id),
        steps=await store.steps_of(request.id),
        notes=await store.notes(request.id),
        hold=waiting[0] if waiting else None,
        others=others,
    )
    entries = story(record, everything=everything)
    return WhyReport(
        id=request.id,
        sentences=told(entries),
        entries=[WhyEntry(**asdict(entry)) for entry in entries],
    )
