"""Frozen states are exact, complete, and say what cannot be kept."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from navigate.freezing import FrozenStateError, freeze, thaw


@dataclass(frozen=True)
class Spot:
    x: float
    y: float


class Inner:
    STATE: ClassVar = ("count",)

    def __init__(self):
        self.count = 0


class Outer:
    STATE: ClassVar = ("random", "array", "spot", "pair", "names", "inner", "nothing", "far")

    def __init__(self):
        self.random = np.random.default_rng(0)
        self.array = np.zeros((2, 3))
        self.spot = Spot(0.0, 0.0)
        self.pair = None
        self.names = {}
        self.inner = Inner()
        self.nothing = None
        self.far = 0.0


def test_a_thawed_object_goes_on_bit_for_bit():
    one, other = Outer(), Outer()
    one.array = one.random.standard_normal((4, 5)).astype(np.float32)
    one.spot, one.pair, one.names = Spot(0.1, 1 / 3), (1, (2.5, "x")), {"a": [1.0, (2.0, None)]}
    one.inner.count, one.far = 7, float("inf")
    thaw(other, json.loads(json.dumps(freeze(one))))
    assert (other.spot, other.pair, other.names) == (one.spot, one.pair, one.names)
    assert other.inner.count == 7
    assert other.far == float("inf")
    assert other.array.dtype == np.float32
    assert (other.array == one.array).all()
    assert (other.random.random(5) == one.random.random(5)).all()


def test_what_cannot_be_kept_is_named():
    thing = Outer()
    thing.nothing = object()
    with pytest.raises(FrozenStateError, match=r"Outer\.nothing holds a object"):
        freeze(thing)
