"""The problems in ``domains/``, what is expected of them, and a search that misses nothing."""

from __future__ import annotations

import tomllib
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rogue.prodigy import Problem, Task, load_task
from rogue.prodigy._simulate import SimulatedWorld, after, cases, holds, start

DOMAINS = Path(__file__).parent / "domains"
OFFICE = Path(__file__).parents[3] / "rogue" / "errands" / "domains" / "office.pdl"

EXPECTED: dict[str, dict[str, Any]] = tomllib.loads((DOMAINS / "expected.toml").read_text())


def load_named(name: str, language: str = "pdl") -> Task:
    """Load a problem by its name, DOMAIN-PROBLEM."""
    domain = DOMAINS / f"{name.partition('-')[0]}.{language}"
    about = OFFICE if name.startswith("office-") else domain
    return load_task(about, DOMAINS / f"{name}.{language}")


def shortest(problem: Problem) -> int | None:
    """Return the least number of steps to the goal, None if it cannot be reached.

    Breadth first, over all values of all variables, by the code that checks plans and none of
    the search's; only for domains without infinite types.
    """
    first = start(problem)
    seen, agenda = {first}, deque([(first, 0)])
    while agenda:
        world, steps = agenda.popleft()
        values = cases(problem, world.facts, problem.variables, {})
        if any(holds(problem, world.facts, problem.goal, case) for case in values):
            return steps
        for following in _following(problem, world):
            if following not in seen:
                seen.add(following)
                agenda.append((following, steps + 1))
    return None


def _following(problem: Problem, world: SimulatedWorld) -> Iterator[SimulatedWorld]:
    for operator in problem.domain.operators:
        for bindings in cases(problem, world.facts, operator.variables, {}):
            if holds(problem, world.facts, operator.precondition, bindings):
                yield after(problem, world, operator, bindings)
