"""The application object behind each of the house's commands."""

from __future__ import annotations

from collections.abc import Mapping
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
        help_format="markdown",
        version=_version,
        error_formatter=_format_error,
        result_action="return_value",
        suppress_keyboard_interrupt=False,
    )


def add_commands(
    app: App, package: str, commands: Mapping[str, tuple[str, str]], *, group: str | None = None
) -> None:
    """Register commands of which only the one that is called is imported.

    Args:
        app: To which.
        package: The package with their modules.
        commands: By the name that the user types: ``module:function``, and what it does, which
            is the first line of the function's docstring.
        group: Heading under which the help shows them.
    """
    for name, (place, summary) in commands.items():
        if group is None:
            app.command(f"{package}.{place}", name=name, help=summary)
        else:
            app.command(f"{package}.{place}", name=name, help=summary, group=group)


def _version() -> str:
    try:
        return version(DISTRIBUTION)
    except PackageNotFoundError:
        return "not installed"


def _format_error(error: CycloptsError) -> str:
    return f"error: {error}"
