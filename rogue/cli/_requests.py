"""The commands with which users post errands and look after them."""

from __future__ import annotations

import uuid
from dataclasses import dataclass
from typing import Annotated, Literal

from cyclopts import Group, Parameter
from cyclopts.validators import Number

from rogue.cli._client import NotAcceptedError, ask, on_bus
from rogue.cli._posting import post
from rogue.cli._waiting import EXIT_CODES, states
from rogue.messages import (
    CancelRequest,
    DeliveryRequest,
    ListRequests,
    PostRequest,
    RequestDetails,
    RequestState,
    ShowRequest,
    Why,
)
from rogue.times import show_deadline, show_time
from tca_bus import Module
from tca_bus.cli import DEFAULT_FLAGS, BusFlags, emit, emit_json, note, show_table

ERRAND_GROUP = Group("Errand", sort_key=10)

COLUMNS = ("id", "user", "item", "from", "to", "state", "rank", "posted", "deadline", "reason")

SOURCES = {
    "directory": "from the people directory",
    "finger": "from the user's finger server",
    "default": "by default",
    "answer": "as somebody answered",
}
"""Where what was filled in came from, in words."""


@Parameter(name="*", group=ERRAND_GROUP)
@dataclass(frozen=True, kw_only=True)
class ErrandFlags:
    """What errand it is."""

    user: str
    """For whom."""
    from_: Annotated[str | None, Parameter(name="--from")] = None
    """Room where it is; if not given, the usual one, or you are asked."""
    to: str | None = None
    """Room where it shall be."""
    deadline: str | None = None
    """ISO 8601, HH:MM, or from now on: +30m, 1h. One hour if not given."""
    why: str | None = None
    """What it is for, in your words."""
    again: Annotated[bool, Parameter(negative="")] = False
    """Have an errand done once more that is open already."""
    anyway: Annotated[bool, Parameter(negative="")] = False
    """Have an errand tried that is not expected to be done by its deadline."""
    id: Annotated[str | None, Parameter(name="--id")] = None
    """Name of the request; posting one name twice makes one request."""

    def message(self, item: str) -> PostRequest:
        """The request for it."""
        return PostRequest(
            id=self.id or uuid.uuid4().hex[:8],
            user=self.user,
            item=item,
            pickup=self.from_,
            deliver=self.to,
            deadline=self.deadline,
            why=self.why,
            again=self.again,
            anyway=self.anyway,
        )


async def request(
    item: str,
    /,
    *,
    errand: ErrandFlags,
    wait: Annotated[bool, Parameter(negative="")] = False,
    flags: BusFlags = DEFAULT_FLAGS,
) -> int:
    """Ask the robot for an errand.

    Parameters
    ----------
    item
        What to carry: delivermail, pickupcoffee, ...
    errand
        What errand it is.
    wait
        Wait for the end: exit code 0 completed, 1 failed, 6 canceled.
    """
    async with on_bus(flags) as module:
        try:
            posted = await post(module, errand.message(item))
        except NotAcceptedError as error:
            if flags.json:
                emit_json(_refused(error), line=True)
            raise
        if not wait:
            _say(posted, flags)
            return 0
        return await _follow(module, posted.id, flags)


async def requests(
    *,
    open_only: Annotated[bool, Parameter(name="--open", negative="")] = False,
    state: Annotated[tuple[RequestState, ...], Parameter(negative="")] = (),
    user: str | None = None,
    limit: Annotated[int | None, Parameter(validator=Number(gte=1))] = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """List the requests, the oldest first.

    Parameters
    ----------
    open_only
        Only those that have not ended.
    state
        Only those in this state; may be given several times.
    user
        Only those of this user.
    limit
        Only so many, those that were posted last.
    """
    question = ListRequests(open_only=open_only, states=state, user=user, most=limit)
    async with on_bus(flags) as module:
        found = await ask(module, question)
    if flags.json:
        emit_json(found)
    else:
        show_table(COLUMNS, [_row(one) for one in found])


async def show(id: str, /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Show one request with the steps that were carried out for it.

    Parameters
    ----------
    id
        The request; 'rogue requests' lists them.
    """
    async with on_bus(flags) as module:
        details = await ask(module, ShowRequest(id=id))
    if flags.json:
        emit_json(details)
        return
    _show_details(details)


async def cancel(
    id: str,
    /,
    *,
    reason: str = "canceled by its user",
    item: Literal["back", "deliver", "keep"] = "back",
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Take a request back, at whatever stage it is.

    Parameters
    ----------
    id
        The request; 'rogue requests' lists them.
    reason
        Why, for the record.
    item
        What becomes of an item that is on the tray: it goes back to where it came from, or is
        delivered all the same, or stays there. The request is open until that is done.
    """
    async with on_bus(flags) as module:
        _say(await ask(module, CancelRequest(id=id, reason=reason, item=item)), flags)


async def why(
    id: str,
    /,
    *,
    everything: Annotated[bool, Parameter(name="--all", negative="")] = False,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Say why a request stands where it does.

    Parameters
    ----------
    id
        The request; 'rogue requests' lists them.
    everything
        Tell each choice of the planner, not only those that make a difference.
    """
    async with on_bus(flags) as module:
        report = await ask(module, Why(id=id, everything=everything))
    if flags.json:
        emit_json(report)
        return
    for sentence in report.sentences:
        emit(sentence)


async def _follow(module: Module, request_id: str, flags: BusFlags) -> int:
    code = 1
    async for one in states(module, request_id):
        _say(one, flags)
        code = EXIT_CODES.get(one.state, code)
        if one.state.is_final and code and not flags.json:
            note(f"error: request {one.id} {one.state.value}: {one.reason}")
    return code


def _refused(error: NotAcceptedError) -> dict[str, object]:
    facts = error.objection.model_dump(exclude_none=True) if error.objection else {}
    return {"refused": error.refusal.value, **facts, "reason": str(error)}


def _say(one: DeliveryRequest, flags: BusFlags) -> None:
    if flags.json:
        emit_json(one, line=True)
        return
    words = f"{one.id}: {one.item} for {one.user}, {one.pickup} to {one.deliver}: {one.state}"
    said = one.reason or _prospect(one)
    emit(f"{words} ({said})" if said else words)


def _prospect(one: DeliveryRequest) -> str | None:
    """What is to be expected of an open request, where that is not its completion in time."""
    closing = one.closing
    if closing is None or one.state.is_final:
        return one.warning
    return f"{closing.state} when its item is in {one.destination}: {closing.reason}"


def _row(one: DeliveryRequest) -> tuple[object, ...]:
    return (
        one.id,
        one.user,
        one.item,
        one.pickup,
        one.deliver,
        one.state.value,
        one.rank,
        show_time(one.posted),
        show_deadline(one.deadline),
        one.reason or _prospect(one),
    )


def _show_details(details: RequestDetails) -> None:
    one = details.request
    show_table(("field", "value"), list(zip(COLUMNS, _row(one), strict=True)))
    if details.why:
        emit(f"why: {details.why}")
    for slot in details.filled:
        emit(f"{slot.slot}: {slot.value}, {SOURCES[slot.source]}")
    if details.on_tray:
        emit("It is on the robot's tray.")
    if prospect := _prospect(one):
        emit(f"{prospect[0].upper()}{prospect[1:]}.")
    if details.steps:
        emit("")
        rows = [(show_time(s.started), s.operator, s.state, s.outcome) for s in details.steps]
        show_table(("begun", "operator", "state", "outcome"), rows)
