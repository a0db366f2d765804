"""``python -m xavier_sim``: the command line ``xavier``."""

from __future__ import annotations

from xavier_sim.cli import main

__all__ = ["main"]

if __name__ == "__main__":
    main()
