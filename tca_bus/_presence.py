"""Which modules are on the bus, as a pure table: tokens and transport events in, changes out.

When the router is lost all liveliness tokens vanish at once, so a vanished token alone says
nothing about its module: the entry becomes a suspect, and is lost only when it has not come back
after a grace, during which the way to the router was open, or when its successor is there.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterable
from dataclasses import dataclass

VANISH_GRACE = 0.5
"""Wall seconds from a vanished token to a lost module: covers a transport event that comes late
and a module that lost and reopened its own link, which it tries four times a second."""

RECONNECT_GRACE = 0.6
"""Wall seconds after a reconnect, and after each module that came back with it, until those that
have not announced themselves again are lost."""

LONGEST_RECONNECT = 10.0
"""Wall seconds after a reconnect until modules are lost though others still come back."""

MOST_REMEMBERED = 10_000
"""Names of messages whose providers are remembered until presence changes."""


class Stage(enum.StrEnum):
    """What a module has said of being ready."""

    UNSAID = ""
    """Nothing: it is ready from the beginning."""
    HELD = "held"
    """It will say when it is ready; until then nothing is delivered to it."""
    WAITING = "waiting"
    """It waits for others before it is ready."""
    READY = "ready"
    """It has said that it is ready."""


@dataclass(frozen=True, slots=True, order=True)
class TapWord:
    """A tap on a query, inform or broadcast, as the token of its module names it.

    ``message`` is a wire name, or ``*``; ``fails`` says that what it holds fails with it.
    """

    condition: str
    message: str
    fails: bool = False


@dataclass(frozen=True, slots=True)
class PresentModule:
    """A module on the bus, as its liveliness token names it.

    ``incarnation`` is new with each start and sorts by start time; ``provides`` are the wire
    names of the messages that it handles. ``resources`` are the resources that it offers beside
    its own name, ``requires`` those that it needs, ``stage`` what it said of being ready.
    ``number`` counts its tokens: of two of one incarnation the higher one holds. ``taps`` are
    those on messages that go straight from module to module.
    """

    name: str
    incarnation: str
    host: str
    pid: int
    provides: tuple[str, ...]
    resources: tuple[str, ...] = ()
    requires: tuple[str, ...] = ()
    stage: Stage = Stage.UNSAID
    number: int = 0
    taps: tuple[TapWord, ...] = ()


@dataclass(frozen=True, slots=True)
class PresenceChange:
    """A module came or changed what it provides (``appeared``), or is gone for good (not)."""

    module: PresentModule
    appeared: bool


class PresenceTable:
    """The modules that are there, and those that may be gone.

    ``own`` is the incarnation of the module that keeps the table; it is never suspected. Times
    are seconds of any monotonic clock.
    """

    def __init__(self, own: str = "") -> None:
        self._own = own
        self._entries: dict[str, PresentModule] = {}
        self._suspects: dict[str, float] = {}
        self._by_name: dict[str, dict[str, PresentModule]] = {}
        self._providers: dict[str, list[PresentModule]] = {}
        # Those who are expected with the router, all by the same time: there may be thousands.
        self._expected: set[str] = set()
        self._expected_by = self._return_by = math.inf
        self._reachable = True

    def modules(self) -> list[PresentModule]:
        """All that are not lost, by name and incarnation."""
        return sorted(self._entries.values(), key=lambda entry: (entry.name, entry.incarnation))

    def expect(self, modules: Iterable[PresentModule], now: float) -> list[PresenceChange]:
        """Take modules for present that have yet to announce themselves."""
        awaited = list(modules)
        changes = [change for module in awaited for change in self.put(module, now)]
        self._providers.clear()
        self._expected |= {module.incarnation for module in awaited} - {self._own}
        self._return_by, self._expected_by = now + LONGEST_RECONNECT, now + RECONNECT_GRACE
        return changes

    def put(self, module: PresentModule, now: float) -> list[PresenceChange]:
        """A token appeared; a namesake whose token vanished was its predecessor, and is lost."""
        known = self._entries.get(module.incarnation)
        # One that its module has replaced since is of no interest.
        if known is not None and known.number > module.number:
            return []
        self._forget_look_ups()
        self._suspects.pop(module.incarnation, None)
        if module.incarnation in self._expected:
            self._expected.remove(module.incarnation)
            # Others still come: a crowd takes longer than a few.
            self._expected_by = min(now + RECONNECT_GRACE, self._return_by)
        if known == module:
            return []
        changes = self._replace(module) if known is None else []
        self._entries[module.incarnation] = module
        self._by_name.setdefault(module.name, {})[module.incarnation] = module
        return [*changes, PresenceChange(module, appeared=True)]

    def delete(self, module: PresentModule, now: float) -> float:
        """A token vanished; one that its module has replaced is of no interest.

        Gives when its module is due to be lost, infinity for never.
        """
        self._forget_look_ups()
        key = module.incarnation
        if self._entries.get(key) == module and key != self._own and key not in self._expected:
            grace = 0.0 if self._has_successor(module) else VANISH_GRACE
            return self._suspects.setdefault(key, now + grace)
        return math.inf

    def router_lost(self, *, is_direct: bool = False) -> None:
        """The transport closed: everybody else is suspect until it is back.

        With direct links only those are whose tokens vanish.
        """
        self._forget_look_ups()
        self._reachable = False
        if is_direct:
            self._suspects = {key: math.inf for key in self._suspects if key != self._own}
            return
        self._suspects.clear()
        self._expected = self._entries.keys() - {self._own}

    def router_back(self, now: float) -> None:
        """The transport opened: suspects have a grace to announce themselves."""
        self._reachable = True
        self._expected |= self._suspects.keys()
        self._suspects.clear()
        self._return_by, self._expected_by = now + LONGEST_RECONNECT, now + RECONNECT_GRACE

    def next_expiry(self) -> float:
        """When `expire` has something to do; infinity for never."""
        if not self._reachable:
            return math.inf
        expected_by = self._expected_by if self._expected else math.inf
        return min(expected_by, min(self._suspects.values(), default=math.inf))

    def expire(self, now: float) -> list[PresenceChange]:
        """Give up suspects whose grace is over."""
        if now < self.next_expiry():
            return []
        self._forget_look_ups()
        lost = [key for key, due in self._suspects.items() if due <= now]
        lost += sorted(self._expected) if self._expected_by <= now else []
        return [self._lose(key) for key in lost]

    def state_of(self, incarnation: str) -> bool | None:
        """True when present, None when suspect, False when lost or never seen."""
        if self._is_suspect(incarnation):
            return None
        return incarnation in self._entries

    def named(self, name: str) -> PresentModule | None:
        """The newest incarnation of a module, suspect or not."""
        entries = self._by_name.get(name, {}).values()
        return max(entries, key=lambda entry: entry.incarnation, default=None)

    def providers(self, message: str) -> list[PresentModule]:
        """The newest incarnation of each module that handles ``message``, certain ones first."""
        found = self._providers.get(message)
        if found is None:
            found = self._find_providers(message)
            if len(self._providers) < MOST_REMEMBERED:
                self._providers[message] = found
        return list(found)

    def _find_providers(self, message: str) -> list[PresentModule]:
        newest: dict[str, PresentModule] = {}
        for entry in self._entries.values():
            known = newest.get(entry.name)
            if known is None or known.incarnation < entry.incarnation:
                newest[entry.name] = entry
        found = [entry for entry in newest.values() if message in entry.provides]
        return sorted(found, key=lambda entry: (self._is_suspect(entry.incarnation), entry.name))

    def has_provider(self, message: str) -> bool:
        """Whether a module that handles ``message`` is there for certain."""
        return any(not self._is_suspect(entry.incarnation) for entry in self.providers(message))

    def is_own_name(self, module: PresentModule) -> bool:
        """Whether a module has the name of the table's own one, or is it."""
        own = self._entries.get(self._own)
        return own is not None and own.name == module.name

    def namesakes(self) -> list[PresentModule]:
        """The modules that are there for certain under the name of the table's own module."""
        own = self._entries.get(self._own)
        if own is None:
            return []
        return [
            entry
            for key, entry in self._by_name[own.name].items()
            if key != self._own and not self._is_suspect(key)
        ]

    def resources(self) -> set[str]:
        """What modules that are there for certain offer: resources, and their own names."""
        certain = [m for key, m in self._entries.items() if not self._is_suspect(key)]
        return {name for module in certain for name in (module.name, *module.resources)}

    def called_ready(self) -> set[str]:
        """The names of the modules that are ready, or wait for others to be."""
        said = {Stage.WAITING, Stage.READY}
        return {module.name for module in self._entries.values() if module.stage in said}

    def _lose(self, incarnation: str) -> PresenceChange:
        self._suspects.pop(incarnation, None)
        self._expected.discard(incarnation)
        module = self._entries.pop(incarnation)
        namesakes = self._by_name[module.name]
        del namesakes[incarnation]
        if not namesakes:
            del self._by_name[module.name]
        return PresenceChange(module, appeared=False)

    def _replace(self, module: PresentModule) -> list[PresenceChange]:
        """Lose the suspects that ``module`` is the next start of."""
        namesakes = self._by_name.get(module.name, {})
        earlier = [key for key in namesakes if key < module.incarnation and self._is_suspect(key)]
        return [self._lose(key) for key in earlier]

    def _has_successor(self, module: PresentModule) -> bool:
        newest = self.named(module.name)
        if newest is None or newest.incarnation <= module.incarnation:
            return False
        return not self._is_suspect(newest.incarnation)

    def _is_suspect(self, incarnation: str) -> bool:
        return incarnation in self._suspects or incarnation in self._expected

    def known_messages(self) -> set[str]:
        """All wire names that somebody handles."""
        return {name for entry in self._entries.values() for name in entry.provides}

    def _forget_look_ups(self) -> None:
        self._providers.clear()
