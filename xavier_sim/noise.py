"""Random streams of the simulated world: one per sensor, seeded, and kept in a snapshot."""

from __future__ import annotations

import zlib
from typing import Any

import numpy as np


def stream(seed: int, name: str) -> np.random.Generator:
    """A random generator that depends on ``seed`` and ``name`` only, on any machine."""
    return np.random.Generator(np.random.PCG64([seed, zlib.crc32(name.encode())]))


def stream_state(generator: np.random.Generator) -> dict[str, Any]:
    """The state of a stream as plain numbers."""
    return dict(generator.bit_generator.state)


def restore_stream(generator: np.random.Generator, state: dict[str, Any]) -> None:
    """Put a stream back into a state that `stream_state` gave."""
    generator.bit_generator.state = state


def derived_seed(seed: int, name: str) -> int:
    """Another seed for something with a name, 0 or more, the same on any machine."""
    return int(np.random.SeedSequence([seed, zlib.crc32(name.encode())]).generate_state(1)[0])
