"""``tca goal``, ``tca command`` and ``tca kill``: tasks by hand."""

from __future__ import annotations

import asyncio
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from tca_bus import Module, NoHandlerError, TaskHandle, TimedOutError
from tca_bus._messages import ModuleLostPolicy
from tca_bus._protocol import KillTask, ProvidedMessage
from tca_bus._sending import SendOptions
from tca_bus.cli._client import NoCentralError, ask_central, joined, provided
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json, note
from tca_bus.cli._payload import JsonText, check_class, check_payload, parse_payload


@Parameter(name="*")
@dataclass(frozen=True, kw_only=True)
class TaskFlags:
    """How a task is sent and waited for."""

    wait: bool = True
    """Wait for the end of the task and print its result; else print its id."""
    priority: int | None = None
    """Of the tasks that wait for one module the highest priority goes first; the message's own by
    default."""
    timeout: float | None = None
    """Wall seconds to wait for the end; the task goes on after that."""
    wait_for_handler: float = 0.0
    """Wall seconds that the task may wait for a module that handles it."""
    id: str | None = None
    """Id of the task; sent again under the same id it is the same task."""
    on_module_lost: ModuleLostPolicy | None = None
    """When the module that handles it dies: fail, resend to the next that handles it, or hold until
    one of the same name is back; the message's own by default."""

    @property
    def options(self) -> SendOptions:
        """The same for a module that sends it."""
        options = SendOptions(
            id=self.id, priority=self.priority, wait_for_handler=self.wait_for_handler
        )
        if self.on_module_lost is not None:
            options["on_module_lost"] = self.on_module_lost
        return options


DEFAULT_TASK_FLAGS = TaskFlags()


async def goal(
    name: str,
    json: JsonText = "{}",
    /,
    *,
    task: TaskFlags = DEFAULT_TASK_FLAGS,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Send a goal and wait for its result; Ctrl-C kills it.

    Parameters
    ----------
    name
        Wire name of the goal; 'tca messages' lists them.
    json
        Its fields as a JSON object; - reads it from standard input.
    """
    await _submit("goal", name, json, task, flags)


async def command(
    name: str,
    json: JsonText = "{}",
    /,
    *,
    task: TaskFlags = DEFAULT_TASK_FLAGS,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Send a command and wait for its result; Ctrl-C kills it.

    Parameters
    ----------
    name
        Wire name of the command; 'tca messages' lists them.
    json
        Its fields as a JSON object; - reads it from standard input.
    """
    await _submit("command", name, json, task, flags)


async def kill(
    id: str,
    /,
    *,
    below: Annotated[bool, Parameter(negative="")] = False,
    reason: str = "",
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Kill a task and all below it.

    Parameters
    ----------
    id
        Id of the task; 'tca tree' shows them.
    below
        Spare the task itself and kill only what is below it.
    reason
        What its sender and the history are told.
    """
    async with joined(flags) as module:
        why = reason or f"killed by {module.name}"
        status = await ask_central(module, KillTask(id=id, reason=why, only_below=below))
    if flags.json:
        emit_json(status)
    elif status.is_ended:
        emit(f"{status.name} {status.id} is {status.state}")
    else:
        emit(f"{status.name} {status.id} will end; it waits for {status.waiting_for}")


async def _submit(
    kind: Literal["goal", "command"], name: str, json: str, task: TaskFlags, flags: BusFlags
) -> None:

    data = parse_payload(name, json)
    async with joined(flags) as module:
        handle = await _send(module, kind, name, data, task)
        if not task.wait:
            emit_json(handle.status) if flags.json else emit(handle.id)
            return
        note(f"{kind} {name} is task {handle.id}")
        await _follow(handle, task.timeout, flags)


async def _send(
    module: Module,
    kind: Literal["goal", "command"],
    name: str,
    data: dict[str, Any],
    task: TaskFlags,
) -> TaskHandle[Any]:

    known = await _provided(module, name, may_wait=task.wait_for_handler > 0)
    check_class(known, name, kind)
    check_payload(known, name, data)
    try:
        return await module.submit_json(
            name,
            data,
            task_class=kind,
            traits=None if known is None else known.traits,
            **task.options,
        )
    except NoHandlerError as error:
        if error.message.startswith("central:"):
            raise NoCentralError(module.options.realm) from error
        raise


async def _provided(module: Module, name: str, *, may_wait: bool) -> ProvidedMessage | None:
    try:
        return await provided(module, name)
    except NoHandlerError:
        if not may_wait:
            raise
        return None


async def _follow(handle: TaskHandle[Any], timeout: float | None, flags: BusFlags) -> None:

    try:
        result = await handle.result(timeout=timeout)
    except TimedOutError:
        note(f"task {handle.id} goes on; 'tca kill {handle.id}' ends it")
        raise
    except asyncio.CancelledError:
        await _kill_interrupted(handle)
        raise
    finally:
        if flags.json:
            emit_json(handle.status)
    if not flags.json:
        emit_json(result)


async def _kill_interrupted(handle: TaskHandle[Any]) -> None:
    status = await handle.kill("interrupted at the command line")
    ending = "is killed" if status.is_ended else "is being killed"
    note(f"interrupted: task {handle.id} {ending}")
