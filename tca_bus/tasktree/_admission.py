"""Which submissions become nodes."""

from __future__ import annotations

from typing import Any

from tca_bus._errors import RefusedError
from tca_bus._protocol import Constraint, Handling, SubmitTask
from tca_bus.tasktree._constraints import check_cycle, check_flags
from tca_bus.tasktree._machine import Machine
from tca_bus.tasktree._node import Node

ROOT = "root"
"""The id that no node may have: it stands for what is above the top-level tasks."""


def check_submission(task: SubmitTask, machine: Machine) -> None:
    """Refuse what cannot become a node; what is one already, by the same message, is fine.

    Raises:
        RefusedError: It says why.
    """
    existing = machine.nodes.get(task.id)
    if existing is not None:
        check_same(task, existing.task.name, existing.task.data)
        return
    if task.id == ROOT:
        raise RefusedError(f"task {ROOT!r}", "that id stands for what is above all tasks")
    check_flags(task.id, Constraint(task.constraints))
    if task.parent is not None:
        _check_parent(task, task.parent, machine)


def check_same(task: SubmitTask, name: str, data: dict[str, Any]) -> None:
    """Refuse a submission under the id of a task that is another.

    Raises:
        RefusedError: name or payload differ; it says which.
    """
    if task.name != name:
        why = f"a task of this id exists and is {name!r}, not {task.name!r}"
        raise RefusedError(f"task {task.id}", why)
    if task.data != data:
        fields = sorted(k for k in {*task.data, *data} if task.data.get(k) != data.get(k))
        why = f"a task of this id exists with other values of {', '.join(fields)}"
        raise RefusedError(f"task {task.id}", why)


def _check_parent(task: SubmitTask, parent_id: str, machine: Machine) -> None:
    parent = machine.nodes.get(parent_id)
    if parent is None or parent.has_ended:
        gone = "is not in the task tree" if parent is None else f"is {parent.state()} already"
        raise RefusedError(f"task {task.id}", f"its parent {parent_id} {gone}")
    if parent.is_alive and parent.handling is Handling.UNHANDLED:
        raise RefusedError(f"task {task.id}", f"its parent {parent_id} is not being handled")
    check_cycle(Node(task, 0.0), [parent, *machine.ancestors(parent)])
