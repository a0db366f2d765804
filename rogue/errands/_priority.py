"""Who comes first: the metric of priorities, which a user may replace as a whole.

Source: Haigh & Veloso (1996), section 4: Priority = PersonRank + TaskRank; (1997), node 8:
+ DeadlineRank, a function of the time to the deadline.
"""

from __future__ import annotations

import importlib
import importlib.util
import math
import sys
import types
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True, kw_only=True)
class Claim:
    """What a metric is told of an errand; times in seconds since the epoch."""

    user: str
    item: str
    person_rank: float = 0.0
    task_rank: float = 0.0
    posted: float = 0.0
    deadline: float = math.inf


Metric = Callable[[Claim, float], float]
"""Priority of an errand at a time, in seconds since the epoch; the higher the sooner."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RankSum:
    """PersonRank + TaskRank + DeadlineRank.

    DeadlineRank grows evenly from nothing, ``within`` seconds before the deadline, to ``most``
    at the deadline.
    """

    most: float = 8.0
    within: float = 1800.0

    def __call__(self, claim: Claim, now: float) -> float:
        """The priority of an errand."""
        return claim.person_rank + claim.task_rank + self.deadline_rank(claim.deadline - now)

    def deadline_rank(self, left: float) -> float:
        """The rank for ``left`` seconds to the deadline."""
        return self.most * min(1.0, max(0.0, 1.0 - left / self.within))


class MetricError(ValueError):
    """A metric of priorities that cannot be used."""

    def __init__(self, metric: str, problem: str) -> None:
        self.metric, self.problem = metric, problem
        super().__init__(
            f"priority {metric!r}: {problem}; expected module:name of a function of a claim "
            "and a time that gives a number"
        )


def load_metric(name: str) -> Metric:
    """The metric named as ``module:name`` or ``FILE.py:name``; a class is called without arguments.

    Raises:
        MetricError: There is none of that name, or it cannot be used.
    """
    where, _, attribute = name.rpartition(":")
    if not where or not attribute:
        raise MetricError(name, "it has no colon")
    try:
        found = getattr(_module(where), attribute)
        metric: Metric = found() if isinstance(found, type) else found
    except Exception as error:
        raise MetricError(name, f"loading it raised {error!r}") from error
    if not callable(metric):
        raise MetricError(name, f"it is {metric!r}")
    measure(metric, Claim(user="somebody", item="something"), 0.0)
    return metric


def _module(where: str) -> types.ModuleType:
    if not where.endswith(".py"):
        return importlib.import_module(where)
    spec = importlib.util.spec_from_file_location(Path(where).stem, where)
    if spec is None or spec.loader is None:
        raise ImportError(where)
    module = importlib.util.module_from_spec(spec)
    # Dataclasses and pickling look a class up in the module that it names.
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def measure(metric: Metric, claim: Claim, now: float) -> float:
    """The priority that a metric gives an errand.

    Raises:
        MetricError: It raises, or gives no number.
    """
    name = getattr(metric, "__qualname__", type(metric).__qualname__)
    try:
        priority = float(metric(claim, now))
    except Exception as error:
        raise MetricError(name, f"for {claim} it raised {error!r}") from error
    if not math.isfinite(priority):
        raise MetricError(name, f"for {claim} it gave {priority}")
    return priority


def guarded(metric: Metric, complain: Callable[[MetricError], None]) -> Metric:
    """A metric that gives the sum of ranks where ``metric`` fails, and complains the first time."""
    complained = False

    def safe(claim: Claim, now: float) -> float:
        nonlocal complained
        try:
            return measure(metric, claim, now)
        except MetricError as error:
            if not complained:
                complained = True
                complain(error)
            return RankSum()(claim, now)

    return safe
