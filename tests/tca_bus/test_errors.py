"""Errors keep their facts wherever they go."""

from __future__ import annotations

import pickle

import pytest

from tca_bus import ConfigError, TcaError, TimedOutError
from xavier_sim.floors import FloorError
from xavier_sim.soak import NavigatorError


@pytest.mark.parametrize(
    "error",
    [
        TcaError("just a sentence"),
        ConfigError("--seed", -1, "0 or more"),
        TimedOutError("task a-1", 3.0),
        NavigatorError("mine", "is not installed"),
        FloorError("floor.yaml", "start", (1, 2), "a point in a space"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_an_error_crosses_processes_with_its_facts(error):
    other = pickle.loads(pickle.dumps(error))
    assert type(other) is type(error)
    assert str(other) == str(error)
    assert vars(other) == vars(error)
    assert other.exit_code == error.exit_code
