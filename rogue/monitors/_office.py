"""All monitors of the office, over one registry."""

from __future__ import annotations

from rogue.conversation import Conversation
from rogue.execution import Executor, Patience
from rogue.monitors._needed import Needed, needed
from rogue.monitors._registry import MonitorRegistry
from rogue.monitors._watchers import BatteryWatcher, DoorWatcher, ItemWatcher, PeopleWatcher
from rogue.requests import RequestBook
from tca_bus import Module


def office_monitors(
    module: Module,
    book: RequestBook,
    executor: Executor,
    conversation: Conversation,
    patience: Patience,
) -> MonitorRegistry:
    """A registry that watches doors, items, people and the battery for open requests.

    After each step of the executor what is known of doors is compared with what comes next.
    """
    doors = DoorWatcher(module, book, executor, conversation, patience)
    watchers = (
        doors,
        ItemWatcher(module, book, executor),
        PeopleWatcher(module, executor),
        BatteryWatcher(module, executor, conversation),
    )
    world = executor.world

    def need() -> Needed:
        return needed(book.open_requests(), world.facts.tray, world.holds())

    executor.after_step = doors.review
    return MonitorRegistry(watchers, need, doors.review, lambda: module.clock)
