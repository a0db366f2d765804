"""Run ``python -m navigate``."""

from __future__ import annotations

from navigate.cli import main

__all__ = ["main"]

if __name__ == "__main__":
    main()
