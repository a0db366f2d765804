"""Monitors: what follows from their conditions, and when they expire."""

from __future__ import annotations

from tca_bus._monitor_spec import Condition
from tca_bus._orders import Point
from tca_bus._protocol import Handling
from tca_bus.tasktree._events import Origin, Role, Triggered
from tca_bus.tasktree._node import Node
from tca_bus.tasktree._steering import Steered


class Monitoring(Steered):
    """Counts what monitors see, fires their actions and lets them end."""

    def _test_once(self, node: Node) -> None:
        """What a point monitor's condition has said."""
        told = Condition.model_validate(node.result or {"satisfied": False})
        if told.satisfied and node.watch is not None:
            node.watch.satisfied += 1
            self._fire_action(node, told.data)

    def _trigger(self, node: Node, event: Triggered) -> None:
        """An interval monitor's condition is satisfied, or its demon fires."""
        watch, monitor = node.watch, node.task.monitor
        if watch is None or monitor is None:
            return
        watch.told = event.number
        watch.satisfied += 1
        if watch.satisfied % monitor.fire_every == 0:
            self._fire_action(node, event.data)
            if monitor.max_fire is not None and watch.fired >= monitor.max_fire:
                self._expire(node)

    def _fire_action(self, node: Node, data: dict[str, object]) -> None:
        if node.watch is None or node.task.monitor is None:
            return
        node.watch.fired += 1
        action = node.task.monitor.action
        origin = Origin(Role.ACTION, node.id)
        given = {**action.data, **{k: v for k, v in data.items() if k in action.data}}
        self._spawn(node, action, origin, data=given)

    def _expire(self, node: Node) -> None:
        """Let a monitor end: it is tested no more, but what it began goes on."""
        if node.watch is None or node.watch.expired or not node.is_alive:
            return
        node.watch.expired = True
        self.touched[node.id] = None
        if node.handling is Handling.HANDLING:
            self._stop(node, "it expired")
        elif not node.answered:
            self.pools.forget(node.id)
            self._answer(node)

    def _expire_last(self, node: Node) -> None:
        """When only monitors hold the end of a node they expire."""
        sources = node.open[Point.END_ACHIEVING]
        if not node.is_alive or not 0 < len(sources) <= len(node.monitors):
            return
        if self._may_pass(node, Point.END_ACHIEVING) and all(
            s.id in node.monitors for s in sources
        ):
            for source in sources:
                self._later(self._expire, self.nodes[source.id])
