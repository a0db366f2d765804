"""The command that runs PRODIGY on any domain."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from rogue._cli_solve import solve as solve_files
from tca_bus.cli import DEFAULT_FLAGS, BusFlags


def solve(
    domain: Path,
    problem: Path,
    /,
    *,
    mode: Literal["saba", "savta"] = "saba",
    level: Annotated[int, Parameter(validator=Number(gte=0, lte=3))] = 2,
    flags: BusFlags = DEFAULT_FLAGS,
) -> int:
    """Plan with PRODIGY: a domain and a problem in its own language.

    Exit code 0 if solved, 1 if there is no plan or the search gave up, 2 for a bad file.

    Args:
        domain: File with the types, operators and control rules.
        problem: File with the objects, the state and the goal.
        mode: saba back-chains before it applies, savta applies as soon as it can.
        level: What is printed: 0 nothing, 1 the plan, 2 nodes, 3 nodes and rules.
        flags: Shared flags; --json prints status, plan, nodes, seconds and trace.
    """
    return solve_files(domain, problem, mode=mode, level=level, json=flags.json)
