"""The things that are carried: what is on the tray, and what went another way."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict

from tca_bus import TcaError
from xavier_sim.messages import Ask, ItemAction

KEPT = 1000
"""Things that went another way and are remembered; the oldest are forgotten."""


class NotMovedError(TcaError, ValueError):
    """A thing is not where somebody wants to take it from; ``why`` says where it is."""

    def __init__(self, user: str, item: str, action: str, why: str) -> None:
        self.user, self.item, self.action, self.why = user, item, action, why
        super().__init__(f"{item} of {user} cannot be {action}: {why}")


class Things(BaseModel):
    """Which things are on the tray, and which somebody took or brought without being asked.

    A thing is named by its user and item. It has gone another way until the robot was told so
    once, by whoever it asks for the thing.
    """

    model_config = ConfigDict(extra="forbid")

    tray: list[str] = []
    gone: dict[str, ItemAction] = {}

    def move(self, user: str, item: str, action: Literal["taken", "brought"]) -> None:
        """Take a thing from the tray unasked, or bring it to its user by hand.

        Raises:
            NotMovedError: it is not on the tray, or it is and so cannot be brought.
        """
        name = _name(user, item)
        if action == "taken":
            if name not in self.tray:
                raise NotMovedError(user, item, action, "it is not on the tray")
            self.tray.remove(name)
        elif name in self.tray:
            raise NotMovedError(user, item, action, "it is on the tray")
        self.gone[name] = action
        while len(self.gone) > KEPT:
            del self.gone[next(iter(self.gone))]

    def is_there(self, ask: Ask) -> bool:
        """Whether the thing that a question is about can be had; it is told only once."""
        return self.gone.pop(_name(ask.user, ask.item), None) is None

    def handed_over(self, ask: Ask, action: ItemAction) -> None:
        """Somebody has put a thing on the tray or taken it from there, as asked."""
        name = _name(ask.user, ask.item)
        if action == "placed" and name not in self.tray:
            self.tray.append(name)
        elif action == "taken" and name in self.tray:
            self.tray.remove(name)


def item_action(ask: Ask, answer: str) -> ItemAction | None:
    """What an answer says was done with an item: placed, taken, or None for nothing."""
    actions: dict[str, ItemAction] = {"placing": "placed", "taking": "taken"}
    return actions.get(ask.about) if answer == "y" and ask.user and ask.item else None


def _name(user: str | None, item: str | None) -> str:
    return f"{user} {item}"
