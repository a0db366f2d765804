"""``rogue solve``: PRODIGY on any domain."""

import sys
from json import dumps
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from rogue.prodigy import (
    Mode,
    ProdigyError,
    SearchOptions,
    SearchResult,
    Status,
    load_domain,
    load_problem,
)
from rogue.prodigy import solve as search


def solve(
    domain: Path,
    problem: Path,
    *,
    mode: Literal["saba", "savta"] = "saba",
    level: Annotated[int, Parameter(validator=Number(gte=0, lte=3))] = 2,
    json: bool = False,
) -> int:
    """Plan with PRODIGY: a domain and a problem in its own language.

    Exit code 0 if solved, 1 if there is no plan or the search gave up, 2 for a bad file.

    Args:
        domain: File with the types, operators and control rules.
        problem: File with the objects, the state and the goal.
        mode: saba back-chains before it applies, savta applies as soon as it can.
        level: What is printed: 0 nothing, 1 the plan, 2 nodes, 3 nodes and rules.
        json: Print one JSON document: status, plan, nodes, seconds, trace.
    """
    try:
        loaded = load_problem(problem, load_domain(domain))
        result = search(loaded, SearchOptions(mode=Mode(mode), level=level))
    except ProdigyError as error:
        return _refused(str(error))
    except OSError as error:
        return _refused(f"{error.filename} cannot be read: {error.strerror}")
    sys.stdout.write(_as_json(result) if json else "".join(f"{line}\n" for line in result.trace))
    return 0 if result.status is Status.SOLVED else 1


def _refused(sentence: str) -> int:
    sys.stderr.write(f"error: {sentence}\n")
    return 2


def _as_json(result: SearchResult) -> str:
    document = {
        "status": result.status.value,
        "plan": [" ".join(map(str, (step.operator, *step.args))) for step in result.plan],
        "nodes": result.nodes,
        "seconds": round(result.seconds, 6),
        "trace": list(result.trace),
    }
    return dumps(document, indent=2) + "\n"
