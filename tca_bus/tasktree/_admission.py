"""Which requests become events of the tree."""

from __future__ import annotations

from typing import Any

from tca_bus._attachments import BLOCKING, OF_TASKS, Attachment, Tap
from tca_bus._errors import RefusedError
from tca_bus._protocol import CENTRAL, Constraint, Handling, SubmitTask
from tca_bus.tasktree._constraints import check_cycle, check_flags
from tca_bus.tasktree._feasible import check_new, check_order
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
    if existing is not None and not existing.prepared:
        check_same(task, existing.task.name, existing.task.data)
        return
    if existing is not None:
        _check_place(task, existing)
    if task.id == ROOT:
        raise RefusedError(f"task {ROOT!r}", "that id stands for what is above all tasks")
    check_flags(task.id, Constraint(task.constraints))
    if task.parent is not None and task.sender != CENTRAL:
        check_parent(task.id, task.parent, machine)
        parent = machine.nodes[task.parent]
        new = Node(task, 0.0, parent.root)
        check_cycle(new, [parent, *machine.ancestors(parent)])


def check_constraints(task: SubmitTask, previous: str | None, machine: Machine) -> None:
    """Refuse a task whose constraints, those that come with it among them, cannot be kept.

    Raises:
        RefusedError: A constraint does not name the task, or cannot be kept.
    """
    for order in task.orders:
        named = {ref.task for ref in (order.first, order.then) if ref is not None}
        if task.id not in named:
            why = f"it comes with task {task.id} and does not name it"
            raise RefusedError(f"the constraint {order}", why)
    parent = machine.nodes.get(task.parent) if task.parent is not None else None
    check_new(task, previous, machine.nodes, root=parent.root if parent else task.id)


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


def check_parent(id: str, parent_id: str, machine: Machine) -> None:
    """Refuse a child of a node that takes none.

    Raises:
        RefusedError: The parent is not in the tree, has ended, or is not being handled.
    """
    parent = machine.nodes.get(parent_id)
    if parent is None or parent.has_ended:
        gone = "is not in the task tree" if parent is None else f"is {parent.state()} already"
        raise RefusedError(f"task {id}", f"its parent {parent_id} {gone}")
    if parent.is_alive and parent.handling is Handling.UNHANDLED:
        raise RefusedError(f"task {id}", f"its parent {parent_id} is not being handled")


def check_attachment(what: Attachment) -> None:
    """Refuse a tap that can never do what it says.

    Raises:
        RefusedError: A blocking tap whose listener cannot be waited for, or a condition that
            tasks do not have.
    """
    if not isinstance(what, Tap):
        return
    one_way = what.listener.task_class in {"inform", "broadcast"}
    if what.condition in BLOCKING and one_way and what.condition != "WhenKilled":
        why = f"{what.condition} waits for its listener, so that must be a goal or a command"
        raise RefusedError(f"the tap {what.id}", why)
    if what.condition not in OF_TASKS and not one_way:
        why = f"{what.condition} is about queries; its listener is an inform or a broadcast"
        raise RefusedError(f"the tap {what.id}", why)


def _check_place(task: SubmitTask, place: Node) -> None:
    """Refuse a task that is not the one for which the place was made."""
    prepared = place.task
    facts = ("name", "task_class", "sender", "parent")
    wrong = [fact for fact in facts if getattr(task, fact) != getattr(prepared, fact)]
    if wrong:
        fact = wrong[0]
        why = (
            f"its place was prepared with {fact} {getattr(prepared, fact)!r}, "
            f"not {getattr(task, fact)!r}"
        )
        raise RefusedError(f"task {task.id}", why)


__all__ = [
    "ROOT",
    "check_attachment",
    "check_constraints",
    "check_order",
    "check_parent",
    "check_same",
    "check_submission",
]
