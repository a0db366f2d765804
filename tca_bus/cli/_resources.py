"""``tca resources``, ``reserve``, ``lock`` and ``unlock``: who has what, and taking it by hand."""

from __future__ import annotations

import asyncio
import time
import uuid
from typing import Annotated

from cyclopts import Parameter

from tca_bus import LeaseLostError, Module, TimedOutError
from tca_bus._resource_messages import (
    AcquireResources,
    CheckHolds,
    HoldKind,
    HoldState,
    HoldStatus,
    ListResources,
    ReleaseResources,
    ResourceStatus,
    ResourceUser,
    UnlockResource,
)
from tca_bus._wire import build
from tca_bus.cli._client import ask_central, joined
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json, note, show_table

LOOK_PERIOD = 0.2
"""Wall seconds between two looks at a lock or reservation that has not begun."""


async def resources(*, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """List all resources: who holds them, who waits and why, what was dropped.

    Things in the world have plain names; those of a module's handlers are MODULE/NAME, and
    MODULE/ stands for all its handlers.
    """
    async with joined(flags) as module:
        listed = await ask_central(module, ListResources())
    if flags.json:
        emit_json(listed)
    elif not listed:
        note("no resource is known to central")
    else:
        columns = ("name", "kind", "capacity", "held by", "waiting", "dropped")
        show_table(columns, [_cells(status) for status in listed])
        for ring in sorted({ring for status in listed for ring in status.cycles}):
            emit(f"for ever: {ring}")


async def reserve(
    name: str,
    /,
    *,
    for_module: Annotated[str, Parameter(name="--for")],
    timeout: float | None = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Reserve a resource for one module until it is unlocked.

    Begins when those who have it have ended; Ctrl-C before that withdraws it.

    Parameters
    ----------
    name
        A resource as 'tca resources' names it; the last part alone where that is clear.
    for_module
        The module whose messages and leases pass.
    timeout
        Wall seconds to wait until it begins; else as long as it takes.
    """
    await _hold(HoldKind.RESERVATION, name, for_module, timeout, flags)


async def lock(
    name: str, /, *, timeout: float | None = None, flags: BusFlags = DEFAULT_FLAGS
) -> None:
    """Lock a resource: nobody's messages and leases pass until it is unlocked.

    Begins when those who have it have ended; Ctrl-C before that withdraws it.

    Parameters
    ----------
    name
        A resource as 'tca resources' names it; the last part alone where that is clear.
    timeout
        Wall seconds to wait until it begins; else as long as it takes.
    """
    await _hold(HoldKind.LOCK, name, None, timeout, flags)


async def unlock(name: str, /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Take a resource from whoever holds it: a lock or reservation, else all leases of it.

    Parameters
    ----------
    name
        A resource as 'tca resources' names it.
    """
    async with joined(flags) as module:
        freed = await ask_central(module, build(UnlockResource, name=name))
    if flags.json:
        emit_json(freed)
    elif not freed:
        note(f"nobody holds {name}")
    for status in [] if flags.json else freed:
        emit(f"the {status.kind} of {', '.join(status.names)} by {status.module} is ended")


async def _hold(
    kind: HoldKind, name: str, passes: str | None, timeout: float | None, flags: BusFlags
) -> None:
    async with joined(flags) as module:
        id = f"operator-{uuid.uuid4().hex[:20]}"
        request = build(AcquireResources, id=id, kind=kind, names=(name,), passes=passes)
        status = await ask_central(module, request)
        try:
            async with asyncio.timeout(timeout):
                status = await _begun(module, status)
        except BaseException as error:
            await ask_central(module, ReleaseResources(id=id))
            if isinstance(error, TimeoutError):
                raise TimedOutError(f"the {kind} of {name}", timeout or 0.0) from error
            raise
    if flags.json:
        emit_json(status)
    else:
        emit(f"{status.names[0]} is under a {kind}; 'tca unlock {status.names[0]}' ends it")


async def _begun(module: Module, status: HoldStatus) -> HoldStatus:
    if status.state is HoldState.WAITING:
        note(f"waits for {status.waiting_for}")
    while status.state is HoldState.WAITING:
        await asyncio.sleep(LOOK_PERIOD)
        found = await ask_central(module, CheckHolds(ids=(status.id,)))
        status = found[0] if found else status
    if status.state is HoldState.ENDED:
        why = status.failure.text if status.failure else "it was withdrawn"
        raise LeaseLostError(status.names, why)
    return status


def _cells(status: ResourceStatus) -> tuple[object, ...]:
    capacity = "any" if status.capacity is None else status.capacity
    holders = ", ".join(_user(user) for user in status.holders)
    waiters = "; ".join(f"{_user(user)} for {user.waiting_for}" for user in status.waiters)
    return status.name, status.kind, capacity, holders or "-", waiters or "-", status.dropped


def _user(user: ResourceUser) -> str:
    what = f"task {user.id}" if user.kind == "task" else f"{user.module} ({user.kind})"
    return f"{what} since {_clock(user.since)}"


def _clock(when: float) -> str:
    return time.strftime("%H:%M:%S", time.localtime(when))
