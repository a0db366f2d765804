"""What the command line is called on the bus."""

from __future__ import annotations

import os


def client_name() -> str:
    """A name of its own for each process, within the rights of the navigator."""
    return f"navigate-{os.getpid()}"
