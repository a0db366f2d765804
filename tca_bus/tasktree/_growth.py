"""How a node comes into the tree: its place, its edges, its beginning."""

from __future__ import annotations

from tca_bus._attachments import Tap, TapCondition
from tca_bus._orders import Point
from tca_bus._protocol import Constraint, SubmitTask
from tca_bus.tasktree._constraints import (
    delayed_edges,
    flags_of,
    own_edges,
    parent_edges,
    sibling_edges,
)
from tca_bus.tasktree._events import Origin, Prepared, Role, Submitted
from tca_bus.tasktree._monitors import Monitoring
from tca_bus.tasktree._node import DEADLINE, Node, Watch

STARTS = (Point.START_PLANNING, Point.START_ACHIEVING, Point.START_HANDLING)


class Growing(Monitoring):
    """Makes nodes, and fills the places that were prepared for them."""

    def prepare(self, event: Prepared) -> None:
        """Make a place for a node that is sent later."""
        task = SubmitTask(
            id=event.id,
            name=event.name,
            task_class=event.task_class,
            data={},
            sender=event.sender,
            parent=event.parent,
        )
        self._place(event.time, task, Origin(), event.taps, prepared=True)
        self._settle()

    def add(self, event: Submitted) -> None:
        """Make a node below its parent, after its previous sibling, or fill its place."""
        node = self.nodes.get(event.id)
        if node is None:
            node = self._place(event.time, event.task, event.origin, event.taps)
        else:
            self._fill(event, node)
        for edge in sibling_edges(node, event.previous or ""):
            if edge[0][1] in event.waits:
                self._connect(*edge)
        for order in event.task.orders:
            self.constrain(order)
        self._begin_alive(node)
        self._settle()

    def _place(
        self,
        time: float,
        task: SubmitTask,
        origin: Origin,
        taps: tuple[Tap, ...],
        *,
        prepared: bool = False,
    ) -> Node:
        parent = self.nodes[task.parent] if task.parent is not None else None
        node = Node(task, time, parent.root if parent else task.id, origin, prepared=prepared)
        self.nodes[node.id] = node
        self._begin(time, node)
        node.open = {point: {} for point in Point}
        node.taps = {tap.id: tap for tap in taps}
        node.priority = task.priority
        if not node.is_goal:
            node.passed = dict.fromkeys((Point.START_PLANNING, Point.END_PLANNING), time)
        if parent is not None:
            self._adopt(parent, node)
        for edge in own_edges(node):
            self._connect(*edge)
        return node

    def _adopt(self, parent: Node, node: Node) -> None:
        parent.children[node.id] = None
        parent.alive[node.id] = None
        if node.is_interval_monitor:
            parent.monitors[node.id] = None
        elif node.role is Role.STEP:
            parent.last_step = node.id
        for edge in parent_edges(node, parent):
            self._connect(*edge)
        if not parent.is_alive and node.role is not Role.CLEAN_UP:
            self._later(self._kill, node, "its parent was killed")

    def _fill(self, event: Submitted, node: Node) -> None:
        """The task of a prepared node has come."""
        self._begin(event.time, node)
        node.task, node.prepared = event.task, False
        node.priority = event.task.priority
        for edge, delay in list(delayed_edges(node)):
            self._connect(*edge, delay)
        for edge in own_edges(node):
            self._connect(*edge)
        if Constraint.DELAY_PLANNING in flags_of(node):
            self._delay_planning(node)

    def _delay_planning(self, node: Node) -> None:
        """Let the times and the twins of the start of planning hold that of achievement."""
        here = (node.id, Point.START_PLANNING)
        for id, point in node.twins.pop(Point.START_PLANNING, ()):
            self.nodes[id].twins[point].remove(here)
            self._pair((node.id, Point.START_ACHIEVING), (id, point))
        for source in list(node.open[Point.START_PLANNING]):
            if source.alarm:
                self._delay_until(node, Point.START_ACHIEVING, node.alarms[source.alarm])

    def _begin_alive(self, node: Node) -> None:
        task = node.task
        for what in task.attachments:
            self.attach(node, what)
        if task.monitor is not None:
            node.watch = Watch()
            if task.monitor.until is not None:
                until = task.monitor.until
                self._connect((until.task, until.point), (node.id, Point.EXPIRY))
        if task.within is not None:
            self._set_alarm(node, DEADLINE, self.now + task.within)
        self._fire(node, TapCondition.WHEN_SENT)
        for point in STARTS:
            self._later(self._try_point, node, point)
