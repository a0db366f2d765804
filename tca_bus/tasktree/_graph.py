"""The points of all nodes and the signals between them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Iterator

from tca_bus._orders import Order, Point, PointRef
from tca_bus._protocol import TaskState
from tca_bus.tasktree._constraints import waiting_point
from tca_bus.tasktree._effects import SetAlarm
from tca_bus.tasktree._events import Released
from tca_bus.tasktree._node import DEADLINE, Node, PointOf, Source


class Graph(ABC):
    """Nodes whose points wait for each other.

    A point passes when all that it waits for has passed, and then signals those that wait for it:
    no time per event depends on the number of nodes. ``touched`` collects the nodes that changed,
    ``crossings`` what follows for other top-level tasks, ``alarms`` the times to be woken at.
    """

    def __init__(self) -> None:
        self.nodes: dict[str, Node] = {}
        self.touched: dict[str, None] = {}
        self.crossings: list[Released] = []
        self.alarms: list[SetAlarm] = []
        self.now = 0.0
        self._agenda: deque[Callable[[], None]] = deque()

    def below(self, id: str) -> Iterator[Node]:
        """The node and all below it, parents first."""
        stack = [id]
        while stack:
            node = self.nodes.get(stack.pop())
            if node is not None:
                yield node
                stack.extend(reversed(node.children))

    def ancestors(self, node: Node) -> Iterator[Node]:
        """The nodes above a node, the nearest first."""
        above = self.parent(node)
        while above is not None:
            yield above
            above = self.parent(above)

    def parent(self, node: Node) -> Node | None:
        """The node above a node, if there is one."""
        return self.nodes[node.task.parent] if node.task.parent is not None else None

    def constrain(self, order: Order) -> None:
        """Make a point wait for another, or for a time."""
        target = self.nodes[order.then.task]
        point = waiting_point(target, order.then.point)
        if order.first is None:
            self._delay_until(target, point, order.at or 0.0)
        elif order.relation == "=":
            other = order.first
            pair = (other.task, waiting_point(self.nodes[other.task], other.point))
            self._pair(pair, (target.id, point))
        elif order.delay or not self._are_together(order.first, target, point):
            first = (order.first.task, order.first.point)
            self._connect(first, (target.id, point), order.delay)

    def together(self, node: Node, point: Point) -> list[tuple[Node, Point]]:
        """The point and those that pass together with it, as far as they have not passed."""
        if point not in node.twins:
            return [(node, point)]
        seen: dict[PointOf, None] = {(node.id, point): None}
        stack = [(node.id, point)]
        while stack:
            id, own_point = stack.pop()
            other = self.nodes.get(id)
            for twin in other.twins.get(own_point, ()) if other else ():
                if twin not in seen:
                    seen[twin] = None
                    stack.append(twin)
        present = [(self.nodes[id], own_point) for id, own_point in seen if id in self.nodes]
        return [(one, own) for one, own in present if own not in one.passed and not one.has_ended]

    def _begin(self, time: float, node: Node) -> None:
        self.now = time
        self.touched[node.id] = None

    def _later(self, step: Callable[..., None], *arguments: object) -> None:
        self._agenda.append(lambda: step(*arguments))

    def _settle(self) -> None:
        while self._agenda:
            self._agenda.popleft()()

    def _connect(self, first: PointOf, then: PointOf, delay: float = 0.0) -> None:
        source, target = self.nodes.get(first[0]), self.nodes.get(then[0])
        if target is None or then[1] in target.passed:
            return
        # What is gone since the record was made is let go by a record too.
        if source is not None:
            when = source.passed.get(first[1], source.ended)
            if when is not None:
                if delay:
                    self._delay_until(target, then[1], when + delay)
                return
            source.waiters.setdefault(first[1], []).append((then, delay))
        target.open[then[1]][Source(first[0], first[1], delay)] = None

    def _pair(self, one: PointOf, other: PointOf) -> None:
        for here, there in ((one, other), (other, one)):
            twins = self.nodes[here[0]].twins.setdefault(here[1], [])
            if there not in twins:
                twins.append(there)

    def _delay_until(self, node: Node, point: Point, when: float) -> None:
        if point in node.passed or when <= self.now:
            return
        node.spawned += 1
        key = f"{point.value} {node.spawned}"
        node.open[point][Source("", None, 0.0, key)] = None
        self._set_alarm(node, key, when)

    def _set_alarm(self, node: Node, key: str, when: float) -> None:
        node.alarms[key] = when
        self.alarms.append(SetAlarm(node.id, key, when, passive=key == DEADLINE))

    def _try_point(self, node: Node, point: Point) -> None:
        """Pass a point, and those that pass together with it, if nothing holds them."""
        if point is Point.START_HANDLING and not node.answered:
            self._try_ready(node)
            return
        group = self.together(node, point)
        if not all(self._is_free(*member) for member in group):
            return
        gated = [self._is_gated(*member) for member in group]
        if any(gated):
            return
        for member, own_point in group:
            self._pass(member, own_point)

    def _are_together(self, first: PointRef, node: Node, point: Point) -> bool:
        """Whether two points pass together anyway, so that none has to wait for the other."""
        group = self.together(node, point)
        return any(first == PointRef(task=one.id, point=own) for one, own in group)

    def _is_free(self, node: Node, point: Point) -> bool:
        """Whether nothing holds the point any more but perhaps a tap."""
        open_ended = point in node.passed or not node.is_alive or node.prepared
        return not open_ended and not node.open[point] and self._may_pass(node, point)

    def _pass(self, node: Node, point: Point) -> None:
        """Mark a point as passed and signal those that wait for it."""
        node.passed[point] = self.now
        self.touched[node.id] = None
        self._signal(node, point)
        self._has_passed(node, point)
        if point is Point.END_ACHIEVING:
            node.fate = TaskState.ACHIEVED
            self._end(node)

    def _signal(self, node: Node, point: Point) -> None:
        for target, delay in node.waiters.pop(point, ()):
            waiting = self.nodes.get(target[0])
            if waiting is not None and waiting.root != node.root:
                self.crossings.append(Released(self.now, target[0], node.id, point, delay))
            else:
                self._later(self._released, target, Source(node.id, point, delay))
        for id, own_point in node.twins.pop(point, ()):
            twin = self.nodes.get(id)
            if twin is not None:
                self._later(self._try_point, twin, own_point)

    def _released(self, target: PointOf, source: Source) -> None:
        node = self.nodes.get(target[0])
        if node is None or source not in node.open[target[1]]:
            return
        del node.open[target[1]][source]
        child = self.nodes.get(source.id)
        if child is None or child.task.parent != node.id or child.origin.gate is not None:
            self.touched[node.id] = None
        if source.delay:
            self._delay_until(node, target[1], self.now + source.delay)
        self._try_point(node, target[1])

    @abstractmethod
    def _try_ready(self, node: Node) -> None:
        """Give a node to a handler, if it may start."""

    @abstractmethod
    def _may_pass(self, node: Node, point: Point) -> bool:
        """Whether the node itself is ready for the point."""

    @abstractmethod
    def _is_gated(self, node: Node, point: Point) -> bool:
        """Whether a blocking tap holds the point; called when nothing else does."""

    @abstractmethod
    def _has_passed(self, node: Node, point: Point) -> None:
        """Do what follows from the passing of a point."""

    @abstractmethod
    def _end(self, node: Node) -> None:
        """End a node."""
