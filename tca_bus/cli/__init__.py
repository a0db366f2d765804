"""What every command line of the house shares: flags, running, errors, tables."""

from typing import TYPE_CHECKING

from tca_bus._lazily import importer as _importer

if TYPE_CHECKING:
    from tca_bus.cli._app import add_commands, make_app
    from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags, bus_options
    from tca_bus.cli._output import emit, emit_json, note, show_table, stdout_is_terminal
    from tca_bus.cli._run import run_app

__all__ = [
    "DEFAULT_FLAGS",
    "BusFlags",
    "add_commands",
    "bus_options",
    "emit",
    "emit_json",
    "make_app",
    "note",
    "run_app",
    "show_table",
    "stdout_is_terminal",
]

_HOMES = {
    "_app": ("add_commands", "make_app"),
    "_flags": ("DEFAULT_FLAGS", "BusFlags", "bus_options"),
    "_output": ("emit", "emit_json", "note", "show_table", "stdout_is_terminal"),
    "_run": ("run_app",),
}

__getattr__ = _importer(__name__, _HOMES)
