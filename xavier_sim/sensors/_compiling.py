"""Compiling for speed where numba is installed; without it functions stay as they are."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec
from typing import Any, TypeVar

F = TypeVar("F", bound=Callable[..., Any])


def can_compile() -> bool:
    """Whether numba is installed."""
    return find_spec("numba") is not None


def compiled(function: F) -> F:
    """A function that numba compiles at its first call, and keeps compiled where it can write.

    It computes what the plain function does, bit for bit: nothing is reordered or fused.
    """
    if not can_compile():
        return function
    njit = import_module("numba").njit
    try:
        return _typed(function, njit(cache=True, error_model="numpy")(function))
    except RuntimeError:  # no folder for the cache can be written
        return _typed(function, njit(error_model="numpy")(function))


def _typed(_like: F, fast: Any) -> F:
    function: F = fast
    return function
