"""``tca policy``: what a policy file says, and what it would say."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tca_bus._errors import ConfigError
from tca_bus._policy import Policy
from tca_bus._policy_file import read_policy
from tca_bus._rights import Right
from tca_bus.cli._flags import DEFAULT_FLAGS, BusFlags
from tca_bus.cli._output import emit, emit_json, show_table

REFUSED = 7
"""Exit code of a question that the policy answers with no."""


def policy(
    file: Path,
    module: str | None = None,
    right: Right | None = None,
    name: str | None = None,
    /,
    *,
    owner: str | None = None,
    flags: BusFlags = DEFAULT_FLAGS,
) -> int:
    """Show what a policy file allows, or ask it: exit code 0 for yes, 7 for no.

    Parameters
    ----------
    file
        Policy file; it is checked whatever is asked.
    module
        Show what this module may do; with a right and a name, ask whether it may.
    right
        What it wants to do.
    name
        With what: the name of a message, resource, variable or, to watch, of a module.
    owner
        Module that sent the task or broadcast that it is about.
    """
    found = read_policy(file)
    if module is None or right is None:
        _show(found, module, flags)
        return 0
    if name is None:
        raise ConfigError("name", None, f"what module {module!r} wants to {right.value}")
    ruling = found.rule(module, right, name, owner=owner)
    if flags.json:
        emit_json({"allowed": ruling.allowed, "reason": ruling.reason})
    else:
        emit(f"{'yes' if ruling else 'no'}: {ruling.reason}")
    return 0 if ruling else REFUSED


def _show(found: Policy, module: str | None, flags: BusFlags) -> None:
    if module is not None and module not in found.modules:
        known = ", ".join(found.modules) or "none"
        raise ConfigError("module", module, f"one that the policy lists: {known}")
    rows = _rows(found, [module] if module is not None else list(found.modules))
    if flags.json:
        emit_json(rows)
        return
    table = [(row["module"], row["right"], ", ".join(row["patterns"])) for row in rows]
    show_table(("module", "right", "what"), table)


def _rows(found: Policy, modules: list[str]) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    for module in modules:
        for right in Right:
            patterns = list(dict.fromkeys(found.patterns(module, right)))
            if patterns:
                rows.append({"module": module, "right": right.value, "patterns": patterns})
    return rows
