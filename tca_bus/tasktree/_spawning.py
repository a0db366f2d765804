"""Nodes that central sends itself: listeners of taps, exception handlers, actions, clean-ups."""

from __future__ import annotations

from hashlib import blake2s
from typing import Any

from tca_bus._attachments import FOLLOWERS, GATES, Sending, Tap, TapCondition, TapNotice
from tca_bus._orders import Point
from tca_bus._protocol import CENTRAL, SubmitTask, TaskState
from tca_bus.tasktree._effects import Tell
from tca_bus.tasktree._events import Origin, Role, Submitted
from tca_bus.tasktree._graph import Graph
from tca_bus.tasktree._node import Node, Source

HANDLER_PATIENCE = 5.0
"""Seconds that a listener, an exception handler or a clean-up waits for a module to handle it."""


class Spawning(Graph):
    """What taps and the like add to the tree.

    ``sends`` collects the nodes to be made; until each is there, its place in the parent is kept.
    ``tells`` collects the one-way messages.
    """

    def __init__(self) -> None:
        super().__init__()
        self.sends: list[Submitted] = []
        self.tells: list[Tell] = []

    def _spawn(self, node: Node, sending: Sending, origin: Origin, *, data: dict[str, Any]) -> str:
        """Send a message as a child of the node."""
        task = _submission(self._new_id(node, origin), sending, data, parent=node.id)
        self._send_below(node, task, origin)
        return task.id

    def _send_below(self, node: Node, task: SubmitTask, origin: Origin) -> None:
        """Keep the place of a new child until it is there; the node does not end before it."""
        node.children[task.id] = None
        node.alive[task.id] = None
        if origin.role in {Role.ACTION, Role.RECOVERY}:
            node.open[Point.END_ACHIEVING][Source(task.id, Point.END_ACHIEVING)] = None
        self.sends.append(Submitted(self.now, task, None, origin=origin))

    def _new_id(self, node: Node, origin: Origin) -> str:
        node.spawned += 1
        facts = f"{node.id} {origin.role} {origin.attachment} {node.spawned}"
        return f"{origin.role.value}-{blake2s(facts.encode(), digest_size=8).hexdigest()}"

    def _is_gated(self, node: Node, point: Point) -> bool:
        """Send the listeners that hold the point, each once a try; whether it is held then."""
        for tap in [tap for tap in node.taps.values() if GATES.get(tap.condition) is point]:
            if tap.id not in node.gated:
                node.gated.add(tap.id)
                origin = Origin(Role.GATE, node.id, tap.id, point)
                child = self._spawn(node, tap.listener, origin, data=_told(tap, node))
                node.open[point][Source(child, Point.END_ACHIEVING)] = None
                self.touched[node.id] = None
        return bool(node.open[point])

    def _fire_followers(self, node: Node, point: Point) -> None:
        if node.taps:
            for condition in FOLLOWERS.get(point, ()):
                self._fire(node, condition)

    def _fire(self, node: Node, condition: TapCondition) -> None:
        """Send the listeners that hold nothing."""
        for tap in [tap for tap in node.taps.values() if tap.condition is condition]:
            self._tell(node, tap)

    def _tell(self, node: Node, tap: Tap) -> None:
        data = _told(tap, node)
        if tap.listener.task_class in {"inform", "broadcast"}:
            self.tells.append(Tell(tap.listener.model_copy(update={"data": data})))
            return
        origin = Origin(Role.LISTENER, node.id, tap.id)
        task = _submission(self._new_id(node, origin), tap.listener, data, parent=None)
        self.sends.append(Submitted(self.now, task, None, origin=origin))

    def _send_rites(self, node: Node) -> bool:
        """Send clean-ups, and taps of a kill, once; whether there is anything to wait for."""
        if node.rites or node.attempt == 0:
            return False
        node.rites = True
        for clean_up in node.clean_ups.values():
            origin = Origin(Role.CLEAN_UP, node.id, clean_up.id)
            self._spawn(node, clean_up.sending, origin, data=clean_up.sending.data)
        for tap in _taps_of_kill(node):
            if tap.listener.task_class in {"inform", "broadcast"}:
                self._tell(node, tap)
            else:
                origin = Origin(Role.CLEAN_UP, node.id, tap.id)
                self._spawn(node, tap.listener, origin, data=_told(tap, node))
        return bool(node.alive)


def _taps_of_kill(node: Node) -> list[Tap]:
    if node.fate is not TaskState.KILLED:
        return []
    return [tap for tap in node.taps.values() if tap.condition is TapCondition.WHEN_KILLED]


def _told(tap: Tap, node: Node) -> dict[str, Any]:
    if tap.payload == "data":
        return {**tap.listener.data, **node.task.data}
    notice = TapNotice(
        condition=tap.condition,
        message=node.task.name,
        data=node.task.data,
        sender=node.task.sender,
        task=node.id,
        reply=node.result,
        failure=node.failure.model_dump(mode="json") if node.failure else None,
    )
    return {**tap.listener.data, **notice.model_dump(mode="json")}


def _submission(
    id: str, sending: Sending, data: dict[str, Any], *, parent: str | None
) -> SubmitTask:
    is_task = sending.task_class in {"goal", "command"}
    return SubmitTask(
        id=id,
        name=sending.name,
        task_class="goal" if is_task and sending.task_class == "goal" else "command",
        message_revision=sending.revision,
        data=data,
        sender=CENTRAL,
        parent=parent,
        constraints=0,
        priority=sending.priority,
        wait_for_handler=HANDLER_PATIENCE,
        grace=sending.traits.grace,
        on_module_lost=sending.traits.on_module_lost,
        on_unhandled=sending.traits.on_unhandled,
    )
