"""Taps of this module on messages that go straight from module to module."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from tca_bus._attaching import AttachmentHandle
from tca_bus._attachments import OF_MESSAGES, Attachment, Tap, TapCondition, TapNotice
from tca_bus._errors import ConfigError, InvalidMessageError
from tca_bus._presence import TapWord
from tca_bus._rights import Right
from tca_bus._tapping import PATIENCE, Action

if TYPE_CHECKING:
    from tca_bus._parts import Parts
    from tca_bus._plain import PlainMessages


@dataclass(frozen=True)
class StraightTaps:
    """Attaches taps to queries, informs and broadcasts. They end with the module."""

    module: PlainMessages
    parts: Parts

    async def attach(self, what: Attachment, message: str) -> AttachmentHandle:
        """Tap a message; its listener is sent from this module.

        Raises:
            ConfigError: It is no tap, or has a condition that only tasks have.
            RefusedError: The policy does not let this module tap it.
        """
        if not isinstance(what, Tap):
            expected = f"a tap: {message!r} is no task, so it cannot have another attachment"
            raise ConfigError("attachment", what.kind, expected)

        if what.listener.name == message:
            raise ConfigError("listener", message, "another message than the one that is tapped")

        async def act(notice: TapNotice) -> None:
            await self._send(what, notice)

        self.listen(what.id, what.condition, message, act, fails=what.on_failure == "fail")
        return AttachmentHandle(what, self._remove)

    def listen(
        self, id: str, condition: TapCondition, message: str, action: Action, *, fails: bool
    ) -> None:
        """Have ``action`` called when the message comes to the condition; see `attach`."""
        if condition not in OF_MESSAGES:
            names = ", ".join(sorted(OF_MESSAGES))
            raise ConfigError("condition", condition.value, f"one of {names} for {message!r}")
        core = self.parts.core
        core.permissions.check(core.name, Right.TAP, message)
        core.tapping.add(id, TapWord(condition.value, message, fails), action)
        self.parts.announce()

    async def _remove(self, id: str) -> bool:
        was_there = self.parts.core.tapping.remove(id)
        self.parts.announce()
        return was_there

    async def _send(self, tap: Tap, notice: TapNotice) -> None:
        """Send the listener, and wait for it if the tap holds the message."""
        listener, data = tap.listener, _data_for(tap, notice)
        match listener.task_class:
            case "inform":
                await self.module.inform_json(listener.name, data)
            case "broadcast":
                await self.module.broadcast_json(listener.name, data)
            case "goal" | "command":
                task = await self.module.submit_json(
                    listener.name,
                    data,
                    task_class=listener.task_class,
                    revision=listener.revision,
                    traits=listener.traits,
                    priority=listener.priority,
                )
                if tap.is_blocking:
                    await task.result(timeout=PATIENCE)


def _data_for(tap: Tap, notice: TapNotice) -> dict[str, Any]:
    """What the listener is given: the message's data, or its reply, or all that is known."""
    if tap.payload == "notice":
        return {**tap.listener.data, **notice.model_dump(mode="json")}
    told = notice.reply if tap.condition is TapCondition.AFTER_REPLIED else notice.data
    if not isinstance(told, dict):
        problem = f"reply: expected an object whose fields are those of the listener, got {told!r}"
        raise InvalidMessageError(tap.listener.name, [problem])
    return {**tap.listener.data, **told}
