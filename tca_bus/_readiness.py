"""What a module offers and needs, and when it is ready (tca.md 3.1)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Self

from tca_bus._errors import ConfigError
from tca_bus._options import CHUNK_EXPECTED, CHUNK_PATTERN
from tca_bus._presence import PresenceTable, Stage


@dataclass(slots=True)
class Readiness:
    """The resources that a module offers and requires by name, and how ready it is."""

    resources: tuple[str, ...]
    requires: tuple[str, ...]
    stage: Stage

    @classmethod
    def declare(cls, provides: Iterable[str], requires: Iterable[str], *, hold: bool) -> Self:
        """Check the names.

        Raises:
            ConfigError: One cannot be a part of a key.
        """
        stage = Stage.HELD if hold else Stage.UNSAID
        return cls(_names("provides", provides), _names("requires", requires), stage)

    def unmet(self, table: PresenceTable, modules: int) -> list[str]:
        """What is still waited for, in words, until ``modules`` modules have called it."""
        waits = [f"resource {name!r}" for name in missing(self.requires, table.resources())]
        lacking = modules - len(table.called_ready())
        if lacking > 0:
            waits.append(f"{lacking} of {modules} modules to be ready")
        return waits


def missing(required: Iterable[str], offered: Iterable[str]) -> list[str]:
    """The required resources that nobody offers, by name."""
    return sorted(set(required) - set(offered))


def _names(option: str, names: Iterable[str]) -> tuple[str, ...]:
    if isinstance(names, str):
        raise ConfigError(option, names, "a list of resource names")
    found = tuple(dict.fromkeys(names))
    for name in found:
        if not CHUNK_PATTERN.fullmatch(name):
            raise ConfigError(option, name, CHUNK_EXPECTED)
    return found
