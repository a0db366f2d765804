"""The command line ``navigate``."""

from navigate.cli._app import app, main

__all__ = [
    "app",
    "main",
]
