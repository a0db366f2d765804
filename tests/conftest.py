"""What all tests share."""

from __future__ import annotations

import os

# Numba takes a second to import: more than it saves a robot that a test starts and soon stops.
os.environ.setdefault("XAVIER_RAYS", "numpy")
