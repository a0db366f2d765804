"""What was seen in a chaos run: what the sender was told, and when who was killed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from chaos_ledger import Entry
from chaos_plan import Plan

from tca_bus import TaskStatus
from tca_bus._protocol import LogEntry


@dataclass(frozen=True)
class Told:
    """What waiting for a task's result came to: the last state, and the failure's name."""

    state: str
    failure: str = ""
    result: Any = None


@dataclass(frozen=True)
class Struck:
    """A kill that was carried out, at a time of the machine's monotonic clock."""

    victim: str
    pid: int
    time: float


@dataclass
class Record:
    """Everything that the verdict is about."""

    plan: Plan
    acknowledged: dict[str, TaskStatus] = field(default_factory=dict)
    told: dict[str, Told] = field(default_factory=dict)
    unended: dict[str, str] = field(default_factory=dict)
    published: dict[str, list[TaskStatus]] = field(default_factory=dict)
    final: dict[str, TaskStatus] = field(default_factory=dict)
    struck: list[Struck] = field(default_factory=list)
    log: list[LogEntry] = field(default_factory=list)
    deeds: list[Entry] = field(default_factory=list)
    seconds: float = 0.0
