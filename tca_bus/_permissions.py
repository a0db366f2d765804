"""What a module asks before it acts, and central before it lets others act."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from tca_bus._errors import RefusedError
from tca_bus._limits import LARGEST_PAYLOAD, Meter, check_size
from tca_bus._policy import ANYBODY, Limit, Policy, Ruling
from tca_bus._presence import PresentModule
from tca_bus._rights import Right

NO_POLICY = Ruling(allowed=True, reason="there is no policy")

MOST_REMEMBERED = 4096
"""Answers that are kept at hand: a module asks the same questions again and again."""

Question = tuple[str, Right, str, str | None]


class Permissions:
    """The policy in force, or none, which allows everything.

    One object lasts as long as its module; ``policy`` is put into it when it is known, and
    again when the router was restarted with another. One that is there from the beginning
    stays: ``is_fixed``.
    """

    def __init__(self, policy: Policy | None = None) -> None:
        self.policy = policy
        self.is_fixed = policy is not None
        self._meter = Meter(time.monotonic)

    @property
    def policy(self) -> Policy | None:
        """The policy in force."""
        return self._policy

    @policy.setter
    def policy(self, policy: Policy | None) -> None:
        self._policy = policy
        self._rulings: dict[Question, Ruling] = {}
        self._limits: dict[tuple[str, str], dict[str, Limit]] = {}

    def rule(self, sender: str, right: Right, name: str, *, owner: str | None = None) -> Ruling:
        """Say whether ``sender`` may, and why; see `Policy.rule`."""
        if self._policy is None:
            return NO_POLICY
        question = (sender, right, name, owner)
        ruling = self._rulings.get(question)
        if ruling is None:
            ruling = self._policy.rule(sender, right, name, owner=owner)
            _remember(self._rulings, question, ruling)
        return ruling

    def may(self, sender: str, right: Right, name: str, *, owner: str | None = None) -> bool:
        """Whether ``sender`` may."""
        return self.rule(sender, right, name, owner=owner).allowed

    def check(self, sender: str, right: Right, name: str, *, owner: str | None = None) -> None:
        """Refuse what ``sender`` may not do.

        Args:
            sender: The name of the module that wants to.
            right: What it wants to do.
            name: With what: see `Right`.
            owner: Who sent the task or broadcast that it is about.

        Raises:
            RefusedError: It may not; the error says what it may.
        """
        if self._policy is None:
            return
        ruling = self.rule(sender, right, name, owner=owner)
        if not ruling.allowed:
            raise RefusedError(f"to {right.value} {name!r}", ruling.reason)

    def check_sending(
        self, sender: str, name: str, size: int, *, right: Right = Right.SEND
    ) -> None:
        """Refuse a message that ``sender`` may not send, or not so big, or not so soon.

        Raises:
            RefusedError: It may not.
        """
        if self._policy is None:
            check_size(name, size, {})
        else:
            self.check(sender, right, name)
            self._meter.check(name, size, self._limits_of(sender, name))

    def check_task(
        self, sender: str, name: str, data: Mapping[str, Any], *, right: Right = Right.SEND
    ) -> None:
        """Refuse a goal or command that ``sender`` may not send, or not so big, or not so soon.

        Raises:
            RefusedError: It may not.
        """
        if self._policy is not None:
            self.check_sending(sender, name, len(json.dumps(data)), right=right)

    def check_task_size(
        self, sender: str, name: str, data: Mapping[str, Any], *, right: Right = Right.SEND
    ) -> None:
        """Refuse a goal or command of another module that it may not send, or not so big.

        Raises:
            RefusedError: It may not.
        """
        self.check(sender, right, name)
        if limits := self._limits_of(sender, name):
            check_size(name, len(json.dumps(data)), limits)

    def check_answer(self, sender: str, name: str, size: int) -> None:
        """Refuse an answer of ``sender`` to a message that is bigger than it may be.

        Raises:
            RefusedError: It is too big.
        """
        if self._policy is not None or size > LARGEST_PAYLOAD:
            check_size(f"the answer to {name}", size, self._limits_of(sender, name))

    def check_listening(self, sender: str, name: str, *, is_inform: bool) -> None:
        """Refuse to listen to a message of which ``sender`` may hear nobody's.

        Raises:
            RefusedError: It may not.
        """
        if not (is_inform and self.may(sender, Right.SERVE, name)):
            self.check(sender, Right.LISTEN, name, owner=ANYBODY)

    def vouch(self, module: PresentModule) -> PresentModule:
        """A module with only those of the messages it says it handles that it may handle."""
        if self._policy is None:
            return module
        names = tuple(n for n in module.provides if self.may(module.name, Right.SERVE, n))
        taps = tuple(t for t in module.taps if self.may(module.name, Right.TAP, t.message))
        return replace(module, provides=names, taps=taps)

    def _limits_of(self, sender: str, name: str) -> dict[str, Limit]:
        if self._policy is None:
            return {}
        found = self._limits.get((sender, name))
        if found is None:
            found = self._policy.limits_of(sender, name)
            _remember(self._limits, (sender, name), found)
        return found


def _remember(table: dict[Any, Any], key: object, value: object) -> None:
    """Keep a value; a full table is emptied, for names that arrive may be endless."""
    if len(table) >= MOST_REMEMBERED:
        table.clear()
    table[key] = value
