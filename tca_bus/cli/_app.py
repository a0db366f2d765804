"""The application object behind each of the house's commands."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError, version

from cyclopts import App, CycloptsError

DISTRIBUTION = "rogue-on-xavier"


def make_app(name: str, *, help: str) -> App:  # noqa: A002 - named as the library names it
    """Make a command line application with the house's habits.

    Usage errors end with exit code 2 and one plain line on standard error.

    Args:
        name: What the user types.
        help: What ``--help`` shows first.
    """
    return App(
        name=name,
        help=help,
        help_format="plaintext",
        version=_version,
        error_formatter=_format_error,
        result_action="return_value",
        suppress_keyboard_interrupt=False,
    )


def _version() -> str:
    try:
        return version(DISTRIBUTION)
    except PackageNotFoundError:
        return "not installed"


def _format_error(error: CycloptsError) -> str:
    return f"error: {error}"
