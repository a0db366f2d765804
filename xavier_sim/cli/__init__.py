"""The command line ``xavier``."""

from xavier_sim.cli._app import main

__all__ = [
    "main",
]
