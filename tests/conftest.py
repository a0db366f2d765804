"""What all tests share."""

from __future__ import annotations

import os
import sys

from hypothesis import HealthCheck, settings

# Tests start hundreds of processes; without bytecode each would compile all of its modules.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# Numba takes a second to import: more than it saves a robot that a test starts and soon stops.
os.environ.setdefault("XAVIER_RAYS", "numpy")

# The same examples each time, and no limit that a busy machine breaks; "search" looks for new ones:
# pytest --hypothesis-profile search
SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large]
settings.register_profile(
    "same", deadline=None, derandomize=True, max_examples=50, suppress_health_check=SLOW
)
settings.register_profile("search", deadline=None, max_examples=200, suppress_health_check=SLOW)
settings.load_profile("same")
