"""Shared variables: what modules and central say of them, and the table that central keeps.

A variable has a value and a sequence number, 1 when it is first set and one more with each change.
Central publishes every change on ``<realm>/variable/<name>`` after it is in the journal.
"""

from __future__ import annotations

import json
from collections import OrderedDict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, overload

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from tca_bus._errors import (
    ConfigError,
    InvalidMessageError,
    NeverSetError,
    RefusedError,
    VariableChangedError,
)
from tca_bus._messages import Query
from tca_bus._options import CHUNK_EXPECTED, CHUNK_PATTERN
from tca_bus._problems import problems_of
from tca_bus._schema import schema_problems

T = TypeVar("T")

MOST_VARIABLES = 10_000
"""Variables of one realm; another is refused."""

MOST_VALUE_BYTES = 64 * 1024
"""Size of a value as JSON; what is bigger belongs in a message."""

MOST_CHANGES = 1000
"""Latest changes whose answers are kept: one that is sent again is made once."""


class Variable(Generic[T]):
    """A variable that all modules of a realm share, by its name.

    ``kind`` is any type that pydantic knows: ``Variable("battery", float)``. The declaration does
    nothing by itself; every module that uses the variable has one.

    Raises:
        ConfigError: The name cannot be a part of a key.
    """

    @overload
    def __init__(self, name: str, kind: type[T]) -> None: ...

    @overload
    def __init__(self, name: str, kind: Any) -> None: ...

    def __init__(self, name: str, kind: Any) -> None:
        if not CHUNK_PATTERN.fullmatch(name):
            raise ConfigError("variable name", name, CHUNK_EXPECTED)
        self.name = name
        self._adapter: TypeAdapter[T] = TypeAdapter(kind)
        self._is_typed = kind is not Any

    def schema(self) -> dict[str, Any] | None:
        """The JSON schema of the value; None when anything will do."""
        return self._adapter.json_schema() if self._is_typed else None

    def encode(self, value: T) -> Any:
        """The value as JSON values.

        Raises:
            InvalidMessageError: It is not of the variable's type.
        """
        return self._adapter.dump_python(self._check(value), mode="json")

    def decode(self, value: Any) -> T:
        """The value that came as JSON values.

        Raises:
            InvalidMessageError: It is not of the variable's type; somebody declares it otherwise.
        """
        return self._check(value)

    def _check(self, value: Any) -> T:
        try:
            return self._adapter.validate_python(value)
        except ValidationError as error:
            problems = [f"value: {text.removeprefix('payload: ')}" for text in problems_of(error)]
            raise InvalidMessageError(f"variable {self.name}", problems) from error


@dataclass(frozen=True, slots=True)
class Reading(Generic[T]):
    """The value of a variable at one moment.

    ``sequence`` counts its changes, ``writer`` is the module that set it, ``changed`` when, in
    seconds since the epoch on central's clock.
    """

    value: T
    sequence: int
    writer: str
    changed: float


class VariableState(BaseModel):
    """A variable as central publishes it on ``<realm>/variable/<name>``.

    ``sequence`` grows by one with each change. ``created`` is when it was first set, in seconds
    since the epoch: it tells the variable of a central that lost its journal from the one before.
    """

    model_config = ConfigDict(frozen=True, ser_json_inf_nan="constants")

    name: str
    value: Any
    sequence: int = Field(ge=1)
    writer: str
    created: float
    changed: float

    def is_newer_than(self, other: VariableState | None) -> bool:
        """Whether this one came later."""
        if other is None:
            return True
        return (self.created, self.sequence) > (other.created, other.sequence)


class VariableChange(BaseModel):
    """What a change did: the state before, None if it had never been set, and after."""

    model_config = ConfigDict(frozen=True, ser_json_inf_nan="constants")

    before: VariableState | None
    after: VariableState


class SetVariable(Query[VariableChange]):
    """Anybody to central: set a variable, and say what it was.

    ``change`` is an id made by the sender: sent twice it is one change. With ``expected`` it is
    set only if its sequence number is that one, 0 for never set. ``value_schema`` is the JSON
    schema of the sender's declaration; a value that does not fit the one that is known is invalid,
    unless ``redefine`` is set.
    """

    wire_name = "tca.var.set"

    name: str = Field(pattern=CHUNK_PATTERN.pattern)
    value: Any
    change: str = Field(min_length=1, max_length=100)
    expected: int | None = Field(default=None, ge=0)
    value_schema: dict[str, Any] | None = None
    redefine: bool = False


class GetVariable(Query[VariableState]):
    """Anybody to central: the state of a variable."""

    wire_name = "tca.var.get"

    name: str = Field(pattern=CHUNK_PATTERN.pattern)


class ListVariables(Query[list[VariableState]]):
    """Anybody to central: all variables that were ever set, by name."""

    wire_name = "tca.var.list"


class VariableTable:
    """The variables of a realm; every change is decided here, one after the other.

    Args:
        states: What is known of each variable from before.
        schemas: Their JSON schemas, by name.
        changes: The latest changes by their ids, the oldest first.
    """

    def __init__(
        self,
        states: Iterable[VariableState] = (),
        schemas: dict[str, dict[str, Any]] | None = None,
        changes: Iterable[tuple[str, VariableChange]] = (),
    ) -> None:
        self._states = {state.name: state for state in states}
        self._schemas = dict(schemas or {})
        self._changes = OrderedDict(changes)

    def get(self, name: str) -> VariableState:
        """The state of a variable.

        Raises:
            NeverSetError: It has none.
        """
        state = self._states.get(name)
        if state is None:
            raise NeverSetError(name, self._states)
        return state

    def all(self) -> list[VariableState]:
        """All states, by name."""
        return [self._states[name] for name in sorted(self._states)]

    def schema(self, name: str) -> dict[str, Any] | None:
        """The schema that the values of a variable have to fit, if one is known."""
        return self._schemas.get(name)

    def made(self, change: str) -> VariableChange | None:
        """What a change did that was made before."""
        return self._changes.get(change)

    def apply(self, order: SetVariable, *, writer: str, now: float) -> VariableChange:
        """Make a change that was not made before; one that was only says again what it did.

        Raises:
            InvalidMessageError: The value does not fit what the variable is declared as.
            VariableChangedError: Its sequence number is not the expected one.
            RefusedError: There are too many variables.
        """
        known = self._changes.get(order.change)
        if known is not None:
            return known
        before = self._states.get(order.name)
        self._check(order, before)
        after = VariableState(
            name=order.name,
            value=order.value,
            sequence=before.sequence + 1 if before else 1,
            writer=writer,
            created=before.created if before else now,
            changed=now,
        )
        return self._take(order, VariableChange(before=before, after=after))

    def _take(self, order: SetVariable, change: VariableChange) -> VariableChange:
        self._states[order.name] = change.after
        if order.value_schema is not None:
            self._schemas[order.name] = order.value_schema
        elif order.redefine:
            self._schemas.pop(order.name, None)
        self._changes[order.change] = change
        while len(self._changes) > MOST_CHANGES:
            self._changes.popitem(last=False)
        return change

    def _check(self, order: SetVariable, before: VariableState | None) -> None:
        if before is None and len(self._states) >= MOST_VARIABLES:
            what = f"variable {order.name!r}"
            raise RefusedError(what, f"there are {MOST_VARIABLES} already")
        found = before.sequence if before else 0
        if order.expected is not None and order.expected != found:
            raise VariableChangedError(order.name, order.expected, found)
        problems = _size_problems(order.value)
        if not order.redefine:
            problems += _type_problems(order.value, self._schemas.get(order.name))
        if problems:
            raise InvalidMessageError(f"variable {order.name}", problems)


def _size_problems(value: Any) -> list[str]:
    size = len(json.dumps(value))
    if size <= MOST_VALUE_BYTES:
        return []
    return [f"value: expected at most {MOST_VALUE_BYTES} bytes of JSON, got {size}"]


def _type_problems(value: Any, schema: dict[str, Any] | None) -> list[str]:
    """What is wrong with a value, named as the field ``value``."""
    if schema is None:
        return []
    whole = {"properties": {"value": schema}, "$defs": schema.get("$defs", {})}
    try:
        return schema_problems({"value": value}, whole)
    except RecursionError:
        return ["value: its schema refers to itself without end"]
