"""The functions that every domain may call without registering them."""

from __future__ import annotations

import operator
from collections.abc import Mapping

from rogue.prodigy._domain import Function

GEN_FROM_PRED = "gen-from-pred"
"""Generates the values of a variable from true literals; built into the generation of bindings."""


def _is_number(value: object) -> bool:
    return isinstance(value, int | float)


def _is_integer(value: object) -> bool:
    return isinstance(value, int)


BUILT_IN: Mapping[str, Function] = {
    "diff": operator.ne,
    "same": operator.eq,
    "=": operator.eq,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "numberp": _is_number,
    "integerp": _is_integer,
}
