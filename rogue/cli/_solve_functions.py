"""Python functions that a user gives to a domain."""

from __future__ import annotations

import importlib
import importlib.util
import types
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

NamedFunctions = dict[str, Callable[..., Any]]


class UserCodeError(Exception):
    """A user's code that gives no functions.

    Attributes:
        place: As the user named it.
        problem: What is wrong with it.
    """

    def __init__(self, place: str, problem: str) -> None:
        self.place = place
        self.problem = problem
        super().__init__(f"functions {place}: {problem}")


def named_functions(places: Iterable[str]) -> NamedFunctions:
    """Return the functions of all ``places`` by the names that a domain uses.

    A place is ``FILE.py`` or a module, and may be followed by ``:NAME`` of a function or of a
    mapping from names to functions. Underscores stand for the hyphens of the domain's names.

    Raises:
        UserCodeError: If the code is not there, raises, or has no such functions.
    """
    found: NamedFunctions = {}
    for place in places:
        where, _, name = place.partition(":")
        module = _module(place, where)
        found.update(_of_module(module) if not name else _named(place, module, name))
    return found


def _module(place: str, where: str) -> types.ModuleType:
    try:
        return _from_file(place, where) if where.endswith(".py") else importlib.import_module(where)
    except UserCodeError:
        raise
    except Exception as error:
        raise UserCodeError(place, f"loading it raised {error!r}") from error


def _from_file(place: str, where: str) -> types.ModuleType:
    spec = importlib.util.spec_from_file_location(Path(where).stem, where)
    if spec is None or spec.loader is None or not Path(where).is_file():
        raise UserCodeError(place, "there is no such file")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _of_module(module: types.ModuleType) -> NamedFunctions:
    public = {name: value for name, value in vars(module).items() if not name.startswith("_")}
    return {_spelled(name): value for name, value in public.items() if _is_of(module, value)}


def _is_of(module: types.ModuleType, value: object) -> bool:
    """Say whether ``value`` is a function of the module's own, or one that it marks."""
    if isinstance(value, types.FunctionType):
        return value.__module__ == module.__name__
    return callable(value) and not isinstance(value, type | types.BuiltinFunctionType)


def _named(place: str, module: types.ModuleType, name: str) -> NamedFunctions:
    value = getattr(module, name, None)
    if isinstance(value, Mapping) and all(map(callable, value.values())):
        return {str(key): function for key, function in value.items()}
    if callable(value):
        return {_spelled(name): value}
    raise UserCodeError(place, f"{name} is neither a function nor a table of functions")


def _spelled(name: str) -> str:
    return name.replace("_", "-")
