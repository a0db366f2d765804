"""The transitions of the nodes: points that pass, nodes that end, and what follows from it."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator

from tca_bus._failure import Failure
from tca_bus._protocol import Existence, Handling, Outcome, TaskState
from tca_bus.tasktree._constraints import Edge, edges, sibling_edges
from tca_bus.tasktree._effects import Cancel
from tca_bus.tasktree._events import (
    Dispatched,
    HandlerLost,
    HandlerMissing,
    Released,
    Reported,
    Submitted,
    Taken,
)
from tca_bus.tasktree._node import Node
from tca_bus.tasktree._points import Point, PointOf
from tca_bus.tasktree._pools import Pools


class Machine:
    """The nodes and their transitions.

    Each public method is one event on one node; it runs until nothing more follows. ``touched``
    collects the nodes that changed, ``cancels`` the handlers to stop, ``crossings`` what follows
    for other top-level tasks, ``ended_roots`` the top-level tasks that ended.
    """

    def __init__(self, pools: Pools) -> None:
        self.nodes: dict[str, Node] = {}
        self.pools = pools
        self.touched: dict[str, None] = {}
        self.cancels: list[Cancel] = []
        self.crossings: list[Released] = []
        self.ended_roots: list[str] = []
        self._agenda: deque[Callable[[], None]] = deque()
        self._now = 0.0

    def add(self, event: Submitted) -> None:
        """Make a node below its parent, after its previous sibling."""
        node = Node(event.task, event.time)
        self.nodes[node.id] = node
        self._begin(event.time, node)
        if not node.is_goal:
            node.passed |= {Point.START_PLANNING, Point.END_PLANNING}
        node.open = {point: {} for point in Point}
        parent = self._parent(node)
        if parent is not None:
            parent.children.append(node.id)
            parent.alive[node.id] = None
        for edge in edges(node, parent):
            self._connect(edge)
        for edge in sibling_edges(node, event.previous or ""):
            if edge[0][1] in event.waits:
                self._connect(edge)
        for point in (Point.START_PLANNING, Point.START_ACHIEVING, Point.START_HANDLING):
            self._later(self._try_point, node, point)
        if parent is not None and not parent.is_alive:
            self._later(self._kill, node, "its parent was killed")
        self._settle()

    def follow(self, event: Released | Taken | Reported | HandlerLost | HandlerMissing) -> None:
        """Let happen what an event says of a node that is there."""
        match event:
            case Released():
                self._let_go(event)
            case Taken():
                self._take(event)
            case Reported():
                self._report(event)
            case HandlerLost():
                self._lose(event)
            case HandlerMissing():
                self._miss(event)

    def _let_go(self, event: Released) -> None:
        """A point of the top-level task before it has passed."""
        node = self.nodes[event.id]
        self._begin(event.time, node)
        for target_point in node.open:
            self._later(self._released, (node.id, target_point), (event.previous, event.point))
        self._settle()

    def dispatched(self, event: Dispatched) -> None:
        """The node was given to a module: handling begins."""
        node = self.nodes[event.id]
        self._begin(event.time, node)
        self.pools.occupy(node.id, node.task.name, event.module, event.incarnation)
        node.attempt, node.handler, node.incarnation = (
            event.attempt,
            event.module,
            event.incarnation,
        )
        node.handling, node.taken = Handling.HANDLING, False
        self._pass(node, Point.START_HANDLING)
        self._settle()

    def _take(self, event: Taken) -> None:
        """The module works on it."""
        node = self.nodes[event.id]
        self._begin(event.time, node)
        node.taken, node.started = True, event.time

    def _report(self, event: Reported) -> None:
        """The handler has ended, in one of three ways."""
        node = self.nodes[event.id]
        self._begin(event.time, node)
        self._leave_handler(node)
        if not node.is_alive:
            self._later(self._try_end, node)
        elif event.outcome is Outcome.SUCCESS:
            self._succeed(node, event)
        elif event.outcome is Outcome.FAILURE:
            self._fail(node, _own_failure(node, event.failure))
        elif node.task.on_module_lost == "resend":
            self._restart(node)
        else:
            self._kill(node, "its handler was cancelled by its module")
        self._settle()

    def _lose(self, event: HandlerLost) -> None:
        """The module that had the node is gone: it fails, or is handled again by the next."""
        node = self.nodes[event.id]
        self._begin(event.time, node)
        self._leave_handler(node)
        if not node.is_alive:
            self._later(self._try_end, node)
        elif node.task.on_module_lost == "resend":
            self._restart(node)
        else:
            text = f"module {event.module!r} was lost while it handled {node.task.name!r}"
            self._fail(node, _failure(node, "module_lost", text, module=event.module))
        self._settle()

    def _miss(self, event: HandlerMissing) -> None:
        """Nobody came to handle the node."""
        node = self.nodes[event.id]
        self._begin(event.time, node)
        text = f"no module came to handle {node.task.name!r}"
        self._fail(node, _failure(node, "no_handler", text))
        self._settle()

    def kill(self, time: float, node: Node, reason: str, *, only_below: bool) -> None:
        """Kill the node and all below it, or only what is below it."""
        self._begin(time, node)
        if only_below:
            self._kill_below(node, reason)
        else:
            self._kill(node, reason)
        self._settle()

    def below(self, id: str) -> Iterator[Node]:
        """The node and all below it, parents first."""
        stack = [id]
        while stack:
            node = self.nodes[stack.pop()]
            yield node
            stack.extend(reversed(node.children))

    def ancestors(self, node: Node) -> Iterator[Node]:
        """The nodes above a node, the nearest first."""
        above = self._parent(node)
        while above is not None:
            yield above
            above = self._parent(above)

    def _parent(self, node: Node) -> Node | None:
        return self.nodes[node.task.parent] if node.task.parent is not None else None

    def _begin(self, time: float, node: Node) -> None:
        self._now = time
        self.touched[node.id] = None

    def _later(self, step: Callable[..., None], *arguments: object) -> None:
        self._agenda.append(lambda: step(*arguments))

    def _settle(self) -> None:
        while self._agenda:
            self._agenda.popleft()()

    def _connect(self, edge: Edge) -> None:
        (source_id, source_point), (target_id, target_point) = edge
        source, target = self.nodes.get(source_id), self.nodes[target_id]
        if target_point in target.passed:
            return
        # A previous sibling that is gone since the record was made is let go by a record too.
        if source is not None:
            if source_point in source.passed or source.has_ended:
                return
            source.waiters.setdefault(source_point, []).append(edge[1])
        target.open[target_point][edge[0]] = None

    def _try_point(self, node: Node, point: Point) -> None:
        if node.open[point] or point in node.passed or not node.is_alive:
            return
        if point is Point.START_HANDLING:
            self._try_ready(node)
        elif point is not Point.END_HANDLING:
            self._pass(node, point)

    def _pass(self, node: Node, point: Point) -> None:
        """Mark a point as passed and signal those that wait for it."""
        node.passed.add(point)
        self.touched[node.id] = None
        self._signal(node, point)
        if point is Point.END_ACHIEVING:
            node.fate = TaskState.ACHIEVED
            self._end(node)

    def _signal(self, node: Node, point: Point) -> None:
        for target_id, target_point in node.waiters.pop(point, ()):
            if self._is_other_root(node, target_id):
                self.crossings.append(Released(self._now, target_id, node.id, point))
            else:
                self._later(self._released, (target_id, target_point), (node.id, point))

    def _is_other_root(self, node: Node, target_id: str) -> bool:
        target = self.nodes.get(target_id)
        is_root = target is not None and target.task.parent is None
        return is_root and node.task.parent is None and target_id != node.id

    def _released(self, target: PointOf, source: PointOf) -> None:
        node = self.nodes.get(target[0])
        if node is not None:
            node.open[target[1]].pop(source, None)
            self._try_point(node, target[1])

    def _try_ready(self, node: Node) -> None:
        if node.is_ready:
            self.touched[node.id] = None
            self.pools.wait(node.id, node.task.name, node.task.priority)

    def _leave_handler(self, node: Node) -> None:
        self.pools.release(node.id, node.task.name, node.incarnation or "")
        node.handling = Handling.HANDLED

    def _succeed(self, node: Node, event: Reported) -> None:
        node.result = event.result
        seen = set(event.seen_failures)
        unseen = [(child, why) for child, why in node.failed.items() if child not in seen]
        if unseen:
            self._fail_by_child(node, *unseen[0])
        else:
            self._pass(node, Point.END_HANDLING)

    def _restart(self, node: Node) -> None:
        """Make the node ready for another try; what the lost try began below it is killed."""
        node.handling, node.handler, node.incarnation = Handling.UNHANDLED, None, None
        node.taken, node.started = False, None
        node.restarting = True
        node.failed.clear()
        self._kill_below(node, "its parent is handled again")
        self._later(self._try_again, node)

    def _try_again(self, node: Node) -> None:
        if node.restarting and not node.alive:
            node.restarting = False
            self._try_ready(node)

    def _fail_by_child(self, node: Node, child: str, cause: Failure) -> None:
        text = f"{self.nodes[child].task.name} below it failed"
        self._fail(node, _failure(node, "child_failed", text, cause=cause))

    def _fail(self, node: Node, failure: Failure) -> None:
        self._terminate(node, TaskState.FAILED, failure)
        self._kill_below(node, "its parent failed")

    def _kill(self, node: Node, reason: str) -> None:
        if not node.is_alive:
            return
        self._terminate(node, TaskState.KILLED, _failure(node, "killed", reason))
        self._kill_below(node, reason)
        if node.handling is Handling.HANDLING:
            stop = Cancel(node.id, node.attempt, node.handler or "", node.incarnation or "", reason)
            self.cancels.append(stop)

    def _kill_below(self, node: Node, reason: str) -> None:
        for child in node.alive:
            self._later(self._kill, self.nodes[child], reason)

    def _terminate(self, node: Node, fate: TaskState, failure: Failure) -> None:
        self.touched[node.id] = None
        node.existence, node.fate, node.failure = Existence.TERMINATING, fate, failure
        node.restarting = False
        self.pools.forget(node.id)
        self._later(self._try_end, node)

    def _try_end(self, node: Node) -> None:
        """End a terminating node once its handler and all below it have ended."""
        busy = node.alive or node.handling is Handling.HANDLING
        if node.existence is Existence.TERMINATING and not busy:
            self._end(node)

    def _end(self, node: Node) -> None:
        """End a node; constraints that point at it are let go."""
        node.existence, node.ended = Existence.TERMINATED, self._now
        self.touched[node.id] = None
        parent = self._parent(node)
        if parent is None:
            self.ended_roots.append(node.id)
        else:
            parent.alive.pop(node.id)
            self._tell_parent(parent, node)
        for point in list(node.waiters):
            self._signal(node, point)

    def _tell_parent(self, parent: Node, child: Node) -> None:
        if not parent.is_alive:
            self._later(self._try_end, parent)
        elif parent.restarting:
            self._later(self._try_again, parent)
        elif child.fate is TaskState.FAILED and child.failure is not None:
            if parent.handling is Handling.HANDLED:
                self._fail_by_child(parent, child.id, child.failure)
            else:
                parent.failed[child.id] = child.failure


def _own_failure(node: Node, failure: Failure | None) -> Failure:
    """The failure as its handler reported it, with the facts that central knows."""
    if failure is None:
        return _failure(node, "failed", f"{node.task.name!r} failed and did not say why")
    facts = {"node": failure.node or node.id, "message": failure.message or node.task.name}
    return failure.model_copy(update={**facts, "module": failure.module or node.handler})


def _failure(
    node: Node, name: str, text: str, *, module: str | None = None, cause: Failure | None = None
) -> Failure:
    return Failure(
        name=name,
        text=text,
        message=node.task.name,
        node=node.id,
        module=module or node.handler,
        cause=cause,
    )
