"""Who may do what: questions in, a yes or no with its reason out.

A policy names modules, what each may do, and limits to size and rate. What it does not allow is
refused. Pure: no files, no bus.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from tca_bus._errors import did_you_mean
from tca_bus._keyring import is_owned, owner_among
from tca_bus._options import CHUNK_EXPECTED, CHUNK_PATTERN
from tca_bus._rights import (
    BUS_PREFIX,
    OF_THINGS,
    OWN_TASKS,
    OWNED_EXPECTED,
    PATTERN_EXPECTED,
    Right,
    is_pattern,
    matches,
    matches_message,
    matches_module,
)

CENTRAL = "central"
"""May do everything: it acts for others, after it has asked the policy itself."""

FROM_CENTRAL = frozenset({"tca.handle", "tca.cancel", "tca.hold"})
"""Messages of the bus that central alone may send."""

GUARDED = frozenset({"tca.simTime"})
"""Messages of the bus that a module may send only if a pattern names them."""

ANYBODY = "*"
"""As an owner: is it allowed for the messages of anybody at all?"""

FINEST_BYTES = 256
"""A smaller limit would not let a task's acknowledgement pass."""


@dataclass(frozen=True, slots=True)
class Ruling:
    """An answer of the policy, and the sentence that says why."""

    allowed: bool
    reason: str

    def __bool__(self) -> bool:
        return self.allowed


def _checked_name(pattern: str) -> str:
    if not is_pattern(pattern):
        raise ValueError(PATTERN_EXPECTED)
    return pattern


def _checked_owned(pattern: str) -> str:
    name, at, owner = pattern.partition("@")
    if not is_pattern(name) or (at and not is_pattern(owner)):
        raise ValueError(OWNED_EXPECTED)
    return pattern


NamePattern = Annotated[str, AfterValidator(_checked_name)]
OwnedPattern = Annotated[str, AfterValidator(_checked_owned)]
Names = tuple[NamePattern, ...]
Owned = tuple[OwnedPattern, ...]


class Grant(BaseModel):
    """What is allowed: for each `Right` the patterns of what it is allowed for."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    send: Names = ()
    serve: Names = ()
    listen: Owned = ()
    watch: Names = ()
    kill: Owned = ()
    suspend: Owned = ()
    prioritise: Owned = ()
    edit: Owned = ()
    tap: Owned = ()
    monitor: Names = ()
    lock: Owned = ()
    read: Names = ()
    write: Names = ()

    def patterns(self, right: Right) -> tuple[str, ...]:
        """Those of one right."""
        found: tuple[str, ...] = getattr(self, right.value)
        return found


class ModuleGrant(Grant):
    """What one module is allowed, beside what everyone and its roles are."""

    roles: tuple[str, ...] = ()


class Limit(BaseModel):
    """The most that messages may have: ``bytes`` each, ``hertz`` of them from one module.

    No two may be closer in time than 1/``hertz`` seconds.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    bytes: int | None = Field(default=None, ge=FINEST_BYTES)
    hertz: float | None = Field(default=None, gt=0, allow_inf_nan=False)

    @model_validator(mode="after")
    def _says_something(self) -> Limit:
        if self.bytes is None and self.hertz is None:
            raise ValueError("bytes, hertz, or both")
        return self


class Policy(BaseModel):
    """Who may do what. See ``docs/security.md`` for the file that it is read from."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    everyone: Grant = Grant()
    roles: dict[str, Grant] = Field(default_factory=dict)
    modules: dict[str, ModuleGrant] = Field(default_factory=dict)
    limits: dict[OwnedPattern, Limit] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _fits_together(self) -> Policy:
        for problem in self._problems():
            raise ValueError(problem)
        return self

    def rule(self, sender: str, right: Right, name: str, *, owner: str | None = None) -> Ruling:
        """Say whether a module may do something.

        Args:
            sender: The name under which the module has joined.
            right: What it wants to do.
            name: With what: the name of a message, resource, variable or, to watch, a module.
            owner: Who sent the broadcast or the task that it is about.
        """
        if is_owned(sender, CENTRAL):
            return Ruling(allowed=True, reason="central may do everything")
        module = owner_among(sender, self.modules)
        if module is None:
            hint = did_you_mean(sender, self.modules)
            return Ruling(allowed=False, reason=f"the policy has no module {sender!r}.{hint}")
        ruling = self._rule_of_the_bus(module, right, name)
        if ruling is None:
            ruling = self._rule_of_ownership(module, right, name, owner)
        if ruling is None:
            ruling = self._rule_of_grants(module, right, name, owner)
        return ruling

    def patterns(self, module: str, right: Right) -> list[str]:
        """All patterns that a listed module has for a right."""
        return [pattern for _, pattern in self._granted(module, right)]

    def limits_of(self, sender: str, name: str) -> dict[str, Limit]:
        """The limits that a message of a module has to keep, by their patterns."""
        return {p: limit for p, limit in self.limits.items() if _fits(p, name, sender, Right.SEND)}

    def _rule_of_the_bus(self, module: str, right: Right, name: str) -> Ruling | None:
        """The bus's own messages: all but some may be sent, heard and served by all."""
        about_messages = right in {Right.SEND, Right.LISTEN, Right.SERVE}
        if not (about_messages and name.startswith(BUS_PREFIX)):
            return None
        if right == Right.SEND and name in FROM_CENTRAL:
            return Ruling(allowed=False, reason=f"only central may send {name!r}, not {module!r}")
        if right == Right.SEND and name in GUARDED:
            return None
        return Ruling(allowed=True, reason=f"{name!r} is a message of the bus itself")

    def _rule_of_ownership(
        self, module: str, right: Right, name: str, owner: str | None
    ) -> Ruling | None:
        owned = name if right == Right.WATCH else owner
        if right in OWN_TASKS and owned is not None and is_owned(owned, module):
            return Ruling(allowed=True, reason=f"it is of module {module!r} itself")
        return None

    def _rule_of_grants(self, module: str, right: Right, name: str, owner: str | None) -> Ruling:
        what = f"{right.value} {_shown(name, owner)}"
        for where, pattern in self._granted(module, right):
            if _fits(pattern, name, owner, right):
                return Ruling(allowed=True, reason=f"{where} has {pattern!r}")
        granted = self.patterns(module, right)
        only = f"only {', '.join(map(repr, granted))}" if granted else "nothing of that kind"
        return Ruling(
            allowed=False,
            reason=f"the policy does not let module {module!r} {what}; {right.value}: {only}",
        )

    def _granted(self, module: str, right: Right) -> Iterator[tuple[str, str]]:
        """Where a pattern stands, and the pattern."""
        grant = self.modules[module]
        places: list[tuple[str, Grant]] = [(f"modules.{module}", grant)]
        places += [(f"roles.{role}", self.roles[role]) for role in grant.roles]
        places.append(("everyone", self.everyone))
        for place, found in places:
            for pattern in found.patterns(right):
                yield f"{place}.{right.value}", pattern

    def _problems(self) -> Iterator[str]:
        for name, grant in self.modules.items():
            if not CHUNK_PATTERN.fullmatch(name):
                yield f"modules.{name}: expected {CHUNK_EXPECTED}"
            if is_owned(name, CENTRAL):
                yield f"modules.{name}: central may do everything; leave it out"
            for role in grant.roles:
                if role not in self.roles:
                    hint = did_you_mean(role, self.roles)
                    known = ", ".join(self.roles) or "none"
                    yield f"modules.{name}.roles: no role {role!r}, there is: {known}.{hint}"
            others = [other for other in self.modules if other != name and is_owned(name, other)]
            if others:
                yield (
                    f"modules.{name}: module {others[0]!r} may use this name too, since it begins "
                    f"with '{others[0]}-'; choose another"
                )
        for pattern, limit in self.limits.items():
            if limit.hertz is not None and pattern.startswith("*"):
                yield (
                    f"limits.{pattern}.hertz: a rate needs a name that begins with a letter, or "
                    "it would count the messages of the bus itself"
                )


def _fits(pattern: str, name: str, owner: str | None, right: Right) -> bool:
    of_name, at, of_owner = pattern.partition("@")
    if not _matcher(right)(of_name, name):
        return False
    return not at or owner == ANYBODY or (owner is not None and matches_module(of_owner, owner))


def _matcher(right: Right) -> Callable[[str, str], bool]:
    if right == Right.WATCH:
        return matches_module
    return matches if right in OF_THINGS else matches_message


def _shown(name: str, owner: str | None) -> str:
    return repr(name) if owner is None else f"{name!r} of {owner!r}"


def parse_policy(data: Any) -> Policy:
    """Validate plain data, such as come over the bus, as a policy.

    Raises:
        ValidationError: They are none.
    """
    return Policy.model_validate(data)
