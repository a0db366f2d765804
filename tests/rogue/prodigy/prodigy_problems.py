"""The problems in ``domains/``, what is expected of them, and a search that misses nothing."""

from __future__ import annotations

import itertools
import tomllib
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rogue.prodigy import Operator, Problem, StepView, Task, load_task, validate_plan
from rogue.prodigy._validate import _after, _Facts, _holds, _wrong_value

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

    Breadth first, over all values of all variables, with the meaning that the checker gives to
    conditions and effects; only for domains without infinite types.
    """
    start = frozenset((f.predicate, f.args) for f in problem.state.facts())
    seen, agenda = {start}, deque([(start, 0)])
    while agenda:
        facts, steps = agenda.popleft()
        if _reached(problem, facts):
            return steps
        for after in _successors(problem, set(facts)):
            if after not in seen:
                seen.add(after)
                agenda.append((after, steps + 1))
    return None


def _reached(problem: Problem, facts: frozenset[Any]) -> bool:
    now = Problem(
        problem.domain, "now", problem.objects, problem.state, problem.goal, problem.variables
    )
    del now
    raise NotImplementedError
