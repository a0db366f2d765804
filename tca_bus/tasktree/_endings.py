"""How nodes end: achieved, failed or killed, and what their ends do to others."""

from __future__ import annotations

from abc import abstractmethod

from tca_bus._failure import Failure
from tca_bus._protocol import Existence, Handling, TaskState
from tca_bus.tasktree._effects import Cancel
from tca_bus.tasktree._events import Role
from tca_bus.tasktree._node import Node
from tca_bus.tasktree._pools import Pools
from tca_bus.tasktree._spawning import Spawning


class Endings(Spawning):
    """Kills and ends nodes.

    ``cancels`` collects the handlers to stop, ``ended`` the nodes that ended, ``ended_roots`` the
    top-level tasks among them.
    """

    def __init__(self, pools: Pools) -> None:
        super().__init__()
        self.pools = pools
        self.cancels: list[Cancel] = []
        self.ended: list[Node] = []
        self.ended_roots: list[str] = []

    def kill(self, time: float, node: Node, reason: str, *, only_below: bool) -> None:
        """Kill the node and all below it, or only what is below it."""
        self._begin(time, node)
        if only_below:
            self._kill_below(node, reason)
        else:
            self._kill(node, reason)
        self._settle()

    def _kill(self, node: Node, reason: str) -> None:
        if not node.is_alive:
            return
        self._terminate(node, TaskState.KILLED, failure(node, "killed", reason))
        self._kill_below(node, reason)
        self._stop(node, reason)

    def _kill_below(self, node: Node, reason: str) -> None:
        for id in node.alive:
            child = self.nodes.get(id)
            if child is not None and child.role is not Role.CLEAN_UP:
                self._later(self._kill, child, reason)

    def _stop(self, node: Node, reason: str) -> None:
        if node.handling is Handling.HANDLING:
            holder = (node.handler or "", node.incarnation or "")
            stop = Cancel(node.id, node.attempt, *holder, reason, node.task.grace)
            self.cancels.append(stop)

    def _terminate(self, node: Node, fate: TaskState, why: Failure) -> None:
        self.touched[node.id] = None
        node.existence, node.fate, node.failure = Existence.TERMINATING, fate, why
        node.restarting = node.failing = node.prepared = node.suspended = False
        node.alarms.clear()
        self.pools.forget(node.id)
        self._later(self._try_end, node)

    def _try_end(self, node: Node) -> None:
        """End a terminating node once its handler and all below it have ended."""
        busy = node.alive or node.handling is Handling.HANDLING
        if node.existence is Existence.TERMINATING and not busy and not self._send_rites(node):
            self._end(node)

    def _end(self, node: Node) -> None:
        """End a node; constraints that point at it are let go."""
        node.existence, node.ended = Existence.TERMINATED, self.now
        node.alarms.clear()
        self.touched[node.id] = None
        self.ended.append(node)
        parent = self.parent(node)
        if parent is None:
            self.ended_roots.append(node.id)
        else:
            parent.alive.pop(node.id, None)
            parent.monitors.pop(node.id, None)
            self._tell_parent(parent, node)
        for point in list(node.waiters):
            self._signal(node, point)
        for point in list(node.twins):
            self._signal(node, point)

    def _tell_parent(self, parent: Node, child: Node) -> None:
        if not parent.is_alive:
            self._later(self._try_end, parent)
        elif parent.restarting:
            self._later(self._try_again, parent)
        elif child.role is Role.RECOVERY and parent.failing:
            self._later(self._recovery_ended, parent, child)
        elif child.fate is TaskState.FAILED and child.failure is not None:
            self._child_failed(parent, child, child.failure)
        elif child.role is Role.GATE and child.fate is TaskState.KILLED:
            self._gate_failed(parent, child)

    def _child_failed(self, parent: Node, child: Node, why: Failure) -> None:
        if child.role is Role.GATE:
            self._gate_failed(parent, child)
        elif child.task.on_unhandled == "go_on" or child.role is Role.CLEAN_UP:
            return
        elif parent.handling is Handling.HANDLED:
            self._fail_by_child(parent, child.task.name, why)
        elif parent.is_interval_monitor:
            self._doom(parent, _by_child(parent, child.task.name, why))
        else:
            parent.failed[child.id] = why

    def _gate_failed(self, parent: Node, child: Node) -> None:
        """The listener of a blocking tap failed: the tapped node goes on, or fails with it."""
        tap = parent.taps.get(child.origin.attachment or "")
        if tap is not None and tap.on_failure == "fail":
            text = f"the tap {tap.condition} by {tap.listener.name!r} did not let it pass"
            why = failure(parent, "tap_failed", text, cause=child.failure)
            self._doom(parent, why)

    def _doom(self, node: Node, why: Failure) -> None:
        """Let a node fail, once its handler has stopped."""
        if node.handling is not Handling.HANDLING:
            self._fail(node, why)
        elif node.doomed is None:
            node.doomed = why
            self._stop(node, why.text)

    def _fail_by_child(self, node: Node, child: str, cause: Failure) -> None:
        self._fail(node, _by_child(node, child, cause))

    @abstractmethod
    def _answer(self, node: Node) -> None:
        """Take the node's handler for done, with success."""

    @abstractmethod
    def _fail(self, node: Node, why: Failure) -> None:
        """Let a node fail, unless an exception handler repairs it."""

    @abstractmethod
    def _try_again(self, node: Node) -> None:
        """Have a restarting node handled again when all of the last try has ended."""

    @abstractmethod
    def _recovery_ended(self, node: Node, handler: Node) -> None:
        """The node of an exception handler has ended while its node still fails."""


def _by_child(node: Node, child: str, cause: Failure) -> Failure:
    facts = {"cause": cause, "kinds": cause.kinds, "uncaught": cause.uncaught}
    return failure(node, "child_failed", f"{child} below it failed").model_copy(update=facts)


def failure(
    node: Node, name: str, text: str, *, module: str | None = None, cause: Failure | None = None
) -> Failure:
    """A failure of a node that central itself states."""
    return Failure(
        name=name,
        text=text,
        message=node.task.name,
        node=node.id,
        module=module or node.handler,
        cause=cause,
    )
