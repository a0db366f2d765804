"""``tca tap``: be told of messages as they come to a point, or let each one pass by hand."""

from __future__ import annotations

import asyncio
import sys
from dataclasses import dataclass, field
from typing import Annotated, Any, cast

from cyclopts import Parameter
from pydantic import create_model

from tca_bus import (
    Broadcast,
    Command,
    ConfigError,
    Module,
    TapCondition,
    TapNotice,
    TaskError,
    tap,
)
from tca_bus._attachments import ANY, BLOCKING
from tca_bus._messages import Message, MessageClass
from tca_bus.cli._answers import TypedLines
from tca_bus.cli._client import joined, provided
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json, note

STRAIGHT = frozenset({MessageClass.QUERY, MessageClass.MULTI_QUERY, MessageClass.INFORM})
"""Classes of messages that do not pass central."""


@dataclass
class Listener:
    """Prints what a tap tells; with ``asks`` a person lets each message pass, or not."""

    flags: BusFlags
    asks: bool
    _turn: asyncio.Lock = field(default_factory=asyncio.Lock)
    _typed: TypedLines = field(default_factory=lambda: TypedLines(sys.stdin.fileno()))

    async def hear(self, notice: TapNotice) -> None:
        """Print a notice, and have a person decide about it, one at a time.

        Raises:
            TaskError: The person does not let it pass, or nobody is there any more.
        """
        async with self._turn:
            if self.flags.json:
                emit_json(notice, line=True)
            else:
                emit(notice_line(notice))
            if self.asks:
                await self._ask()

    async def _ask(self) -> None:
        note("let it pass? [y/n]")
        answer = await self._typed.next()
        if answer is None:
            raise TaskError("nobody_there", "standard input has ended: nobody can let it pass")
        if answer.strip().lower() not in {"y", "yes"}:
            raise TaskError("not_let_pass", "a person did not let it pass")


async def tap_message(
    condition: str,
    name: str,
    /,
    *,
    ask: Annotated[bool, Parameter(negative="")] = False,
    flags: BusFlags = DEFAULT_FLAGS,
) -> None:
    """Print each message that comes to a condition, until interrupted.

    Parameters
    ----------
    condition
        One of TCA's, such as WhenSent, AfterReplied, AfterAchieved, WhenKilled.
    name
        Wire name of the message; * for every goal and command.
    ask
        Ask at the terminal whether each may pass; what may not, fails. For the conditions that
        hold the message: BeforeHandling, BeforePlanning, BeforeAchieving, WhenSuccess,
        WhenFailure, WhenPlanned, WhenAchieved, WhenKilled. What waits for an answer when the
        command ends goes on.
    """
    made = tap(condition, Broadcast)
    if ask and made.condition not in BLOCKING:
        names = ", ".join(sorted(BLOCKING))
        raise ConfigError("--ask", condition, f"a condition that holds the message: {names}")
    async with joined(flags) as module:
        is_straight = await _is_straight(module, name)
        listener = Listener(flags, ask)
        note(f"tapping {made.condition} of {name}; Ctrl-C ends it")
        if is_straight:
            taps = module._straight  # noqa: SLF001
            taps.listen(made.id, made.condition, name, listener.hear, fails=ask)
            await module.serve_forever()
        elif made.condition in BLOCKING:
            await _hold(module, made.condition, name, listener)
        else:
            await _follow(module, made.condition, name, listener)


def notice_line(notice: TapNotice) -> str:
    """A notice in one line."""
    parts = [notice.condition.value, notice.message]
    if notice.task:
        parts.append(notice.task)
    parts.append(f"from {notice.sender}")
    facts: list[Any] = [notice.data]
    if notice.reply is not None:
        facts.append(f"-> {notice.reply}")
    if notice.failure is not None:
        facts.append(f"failed: {notice.failure.get('text')}")
    return "  ".join([*parts, *map(str, facts)])


async def _is_straight(module: Module, name: str) -> bool:
    """Whether the message goes straight from module to module.

    Raises:
        NoHandlerError: Nobody handles it.
    """
    if name == ANY:
        return False
    told = await provided(module, name)
    return told is not None and told.message_class in STRAIGHT


async def _follow(module: Module, condition: TapCondition, name: str, listener: Listener) -> None:
    kind = _listener_type(module, Broadcast)
    heard = module.subscribe(kind)
    async with heard, await module.attach(tap(condition, kind), to=name):
        async for notice in heard:
            await listener.hear(notice)  # type: ignore[arg-type]


async def _hold(module: Module, condition: TapCondition, name: str, listener: Listener) -> None:
    kind = _listener_type(module, Command)

    async def hear(notice: TapNotice, _: object) -> None:
        await listener.hear(notice)

    module.serve(kind, hear)
    await module.wait_for(kind, timeout=5.0)
    made = tap(condition, kind, on_failure="fail" if listener.asks else "ignore")
    async with await module.attach(made, to=name):
        await module.serve_forever()


def _listener_type(module: Module, kind: type[Message]) -> type[Message]:
    """A message type of this command alone, so that two of it do not hear each other's."""
    made = cast("type[Message]", create_model("Tapped", __base__=(TapNotice, kind)))
    made.wire_name = f"tapped.{module.name}"
    return made
