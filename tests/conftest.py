"""What all tests share."""

from __future__ import annotations

import os
import sys

# Tests start hundreds of processes; without bytecode each would compile all of its modules.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

# Numba takes a second to import: more than it saves a robot that a test starts and soon stops.
os.environ.setdefault("XAVIER_RAYS", "numpy")
