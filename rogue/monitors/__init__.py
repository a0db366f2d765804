"""What pending plans depend on, watched for as long as they do."""

from __future__ import annotations

from rogue.monitors._needed import Kind, Monitor, Needed, needed
from rogue.monitors._office import office_monitors
from rogue.monitors._registry import MonitorRegistry, Watcher
from rogue.monitors._watchers import BatteryWatcher, DoorWatcher, ItemWatcher, PeopleWatcher

__all__ = [
    "BatteryWatcher",
    "DoorWatcher",
    "ItemWatcher",
    "Kind",
    "Monitor",
    "MonitorRegistry",
    "Needed",
    "PeopleWatcher",
    "Watcher",
    "needed",
    "office_monitors",
]
