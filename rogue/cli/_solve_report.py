"""What ``rogue solve`` says of a search."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from rogue.prodigy import PlanFault, SearchResult, Status, StepView, Task

Plan = tuple[StepView, ...]


@dataclass(frozen=True, slots=True)
class Report:
    """A search that has ended.

    Attributes:
        task: What was asked for.
        result: What came out.
        plans: Where several were searched for, all that were found, in that order.
        is_checked: Whether the plan was checked.
        fault: What the check has found wrong with the plan.
    """

    task: Task
    result: SearchResult
    plans: tuple[Plan, ...] = ()
    is_checked: bool = False
    fault: PlanFault | None = None

    def lines(self, level: int) -> Iterator[str]:
        """Yield the trace and, unless the level is 0, the plan and a line that sums it up."""
        yield from self.result.trace
        if level > 1:
            yield from (f"\t{step}" for step in self.result.plan)
        if level:
            yield from self._found()
            yield self._summary()
        if self.is_checked:
            yield f"checked: {self._verdict()}"

    def document(self) -> dict[str, Any]:
        """Return the JSON document."""
        result = self.result
        is_solved = result.status is Status.SOLVED
        plans = self.plans or (result.plan,) * is_solved
        return {
            "status": result.status.value,
            "reason": result.reason,
            "plan": _steps(result.plan),
            "cost": self._cost(result.plan) if is_solved else None,
            "valid": self.fault is None if self.is_checked else None,
            "nodes": result.nodes,
            "seconds": round(result.seconds, 6),
            "solutions": [{"plan": _steps(p), "cost": self._cost(p)} for p in plans],
            "trace": list(result.trace),
        }

    def _found(self) -> Iterator[str]:
        for number, plan in enumerate(self.plans, start=1):
            yield f"solution {number}: {self._measures(plan)}"

    def _measures(self, plan: Plan) -> str:
        steps = _count(len(plan), "step")
        return f"{steps} at a cost of {self._cost(plan):g}" if self.task.costs.actions else steps

    def _summary(self) -> str:
        result = self.result
        spent = f"{_count(result.nodes, 'node')}, {result.seconds:.3f} s"
        if result.status is not Status.SOLVED:
            return f"{result.status.value}: {spent}"
        return f"solved: {self._measures(result.plan)}; {spent}"

    def _cost(self, plan: Plan) -> float:
        cost = self.task.costs.total(plan)
        return int(cost) if cost.is_integer() else cost

    def _verdict(self) -> str:
        if self.fault is None:
            return "the plan is valid"
        return f"the plan fails at step {self.fault.step + 1}: {self.fault.problem}"


def _steps(plan: Plan) -> list[str]:
    return [" ".join(map(str, (step.operator, *step.args))) for step in plan]


def _count(number: int, what: str) -> str:
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
