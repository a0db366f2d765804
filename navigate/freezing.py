"""The state of an object as JSON holds it, from which an equal one goes on bit for bit.

A class lists in ``STATE`` the attributes that change while it works; those that follow from its
arguments, such as maps and tables, it leaves out. Values are numbers, texts, None, tuples, lists,
dictionaries with textual keys, numpy arrays and generators, dataclasses, and other such objects.
JSON keeps Python's floats exactly; what is not finite it keeps as Python's own ``json`` does.
"""

from __future__ import annotations

import dataclasses
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np


@runtime_checkable
class Freezable(Protocol):
    """Lists the attributes that are its state."""

    STATE: ClassVar[tuple[str, ...]]


class FrozenStateError(TypeError):
    """A value can be no state. ``where`` is its attribute, ``kind`` its type."""

    def __init__(self, where: str, kind: str) -> None:
        self.where, self.kind = where, kind
        super().__init__(
            f"{where} holds a {kind}; state is numbers, texts, arrays, generators, dataclasses, "
            "and objects with STATE"
        )


def freeze(thing: Freezable) -> dict[str, Any]:
    """The state of an object.

    Raises:
        FrozenStateError: an attribute holds what cannot be kept.
    """
    name = type(thing).__name__
    return {one: _encode(getattr(thing, one), f"{name}.{one}") for one in thing.STATE}


def thaw(thing: Freezable, state: dict[str, Any]) -> None:
    """Put an object that was made with the same arguments into a state that `freeze` gave."""
    for name in thing.STATE:
        setattr(thing, name, _decode(state[name], getattr(thing, name)))


def _encode(value: Any, where: str) -> Any:
    match value:
        case None | bool() | int() | float() | str():
            return value
        case np.ndarray():
            return {"array": value.ravel().tolist(), "of": value.dtype.str, "shape": value.shape}
        case np.random.Generator():
            return {"random": value.bit_generator.state}
        case tuple():
            return {"tuple": [_encode(one, where) for one in value]}
        case list():
            return [_encode(one, where) for one in value]
        case dict():
            return {"dict": {name: _encode(one, where) for name, one in value.items()}}
        case Freezable():
            return {"state": freeze(value)}
        case _ if dataclasses.is_dataclass(value):
            fields = [field.name for field in dataclasses.fields(value)]
            return {"fields": {name: _encode(getattr(value, name), where) for name in fields}}
    raise FrozenStateError(where, type(value).__name__)


def _decode(value: Any, now: Any) -> Any:
    """The value of an attribute that holds ``now``."""
    match value:
        case {"array": data, "of": kind, "shape": shape}:
            return np.array(data, dtype=kind).reshape(shape)
        case {"random": state}:
            now.bit_generator.state = state
            return now
        case {"tuple": data}:
            return tuple(_decode(one, None) for one in data)
        case {"dict": data}:
            return {name: _decode(one, None) for name, one in data.items()}
        case {"state": state}:
            thaw(now, state)
            return now
        case {"fields": fields}:
            old = {name: getattr(now, name) for name in fields}
            return type(now)(**{name: _decode(fields[name], old[name]) for name in fields})
        case list():
            return [_decode(one, None) for one in value]
    return value
