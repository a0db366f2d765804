"""``tca suspend``, ``resume``, ``retry`` and ``prioritize``: tasks that are under way, by hand."""

from __future__ import annotations

from tca_bus import Query, TaskStatus
from tca_bus._tree_queries import PrioritizeTask, RetryTask, SuspendTask
from tca_bus.cli._client import ask_central, joined
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json


async def suspend(id: str, /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Give nothing at or below a task to a handler any more; handlers that run go on.

    Parameters
    ----------
    id
        Id of the task; 'tca tree' shows them.
    """
    await _ask(SuspendTask(id=id), flags)


async def resume(id: str, /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Let a suspended task go on.

    Parameters
    ----------
    id
        Id of the task.
    """
    await _ask(SuspendTask(id=id, resume=True), flags)


async def retry(id: str, /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Stop what runs of a living task and below it, and have it handled again.

    Parameters
    ----------
    id
        Id of the task.
    """
    await _ask(RetryTask(id=id), flags)


async def prioritize(id: str, priority: int, /, *, flags: BusFlags = DEFAULT_FLAGS) -> None:
    """Change the priority of a task and put what waits in order again.

    Parameters
    ----------
    id
        Id of the task; of a top-level task all that is below it moves too.
    priority
        The higher goes first.
    """
    await _ask(PrioritizeTask(id=id, priority=priority), flags)


async def _ask(question: Query[TaskStatus], flags: BusFlags) -> None:
    async with joined(flags) as module:
        status = await ask_central(module, question)
    if flags.json:
        emit_json(status)
        return
    words = [f"{status.name} {status.id} is {status.state}"]
    if status.suspended:
        words.append("suspended")
    if status.waiting_for:
        words.append(f"waits for {status.waiting_for}")
    words.append(f"priority {status.priority}")
    emit(", ".join(words))
