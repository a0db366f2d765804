"""The transitions of the nodes: what each event does, until nothing more follows."""

from __future__ import annotations

from tca_bus._failure import Failure
from tca_bus._monitor_spec import MonitorReport
from tca_bus._orders import Point
from tca_bus._protocol import Handling, Outcome
from tca_bus.tasktree._endings import failure
from tca_bus.tasktree._events import (
    Abandoned,
    Alarmed,
    Attached,
    CaughtFailure,
    Constrained,
    Detached,
    Dispatched,
    HandlerLost,
    HandlerMissing,
    LimitExceeded,
    NodeEvent,
    Prioritized,
    Released,
    Reported,
    Resumed,
    Retried,
    Role,
    Suspended,
    Taken,
    Triggered,
    UncaughtFailure,
)
from tca_bus.tasktree._growth import Growing
from tca_bus.tasktree._node import DEADLINE, Node, Source


class Machine(Growing):
    """The nodes and their transitions. Each public method is one event on one node."""

    def follow(self, event: NodeEvent) -> None:
        """Let happen what an event says of a node that is there."""
        node = self.nodes[event.id]
        self._begin(event.time, node)
        match event:
            case Constrained():
                self.constrain(event.order)
                self._look_again(node)
            case Released():
                self._let_go(node, event)
            case Dispatched():
                self._dispatched(node, event)
            case Taken():
                node.taken, node.started = True, event.time
            case Reported():
                self._report(node, event)
            case _:
                self._interrupt(node, event)
        self._settle()

    def _interrupt(self, node: Node, event: NodeEvent) -> None:
        match event:
            case HandlerLost():
                self._lose(node, event)
            case HandlerMissing():
                self._fail(node, _missing(node))
            case LimitExceeded():
                self._drop(node, event)
            case Abandoned():
                self._abandon(node)
            case Alarmed():
                self._alarm(node, event.key)
            case Triggered():
                self._trigger(node, event)
            case CaughtFailure():
                self._caught(node, event)
            case UncaughtFailure():
                self._give_up(node)
            case _:
                self._change(node, event)

    def _change(self, node: Node, event: NodeEvent) -> None:
        match event:
            case Suspended():
                self._suspend(node)
            case Resumed():
                self._resume(node)
            case Prioritized():
                self._prioritize(node, event.priority)
            case Retried():
                self._restart(node, is_retry=True)
            case Attached():
                self.attach(node, event.what)
                self._look_again(node)
            case Detached():
                self._detach(node, event.attachment)
            case _:
                raise TypeError(f"{type(event).__name__} is no change of a node")

    def _may_pass(self, node: Node, point: Point) -> bool:
        match point:
            case Point.START_HANDLING | Point.END_HANDLING:
                return node.answered
            case Point.START_RECOVERY:
                return node.failing
            case Point.END_ACHIEVING:
                return not node.failing and not node.restarting
            case Point.EXPIRY:
                return node.task.monitor is not None and node.task.monitor.until is not None
            case _:
                return True

    def _has_passed(self, node: Node, point: Point) -> None:
        self._fire_followers(node, point)
        match point:
            case Point.START_RECOVERY:
                self._seek(node)
            case Point.EXPIRY:
                self._expire(node)
            case Point.START_HANDLING if node.answered:
                self._later(self._try_point, node, Point.END_HANDLING)

    def _try_point(self, node: Node, point: Point) -> None:
        if point is Point.END_ACHIEVING:
            self._expire_last(node)
        super()._try_point(node, point)

    def _let_go(self, node: Node, event: Released) -> None:
        """A point of another top-level task has passed."""
        source = Source(event.previous, event.point, event.delay)
        for point in list(node.open):
            self._later(self._released, (node.id, point), source)

    def _dispatched(self, node: Node, event: Dispatched) -> None:
        """The node was given to a module: handling begins."""
        self.pools.occupy(node.id, node.task.name, event.module, event.incarnation)
        node.attempt, node.handler, node.incarnation = (
            event.attempt,
            event.module,
            event.incarnation,
        )
        node.handling, node.taken, node.only = Handling.HANDLING, False, None
        if node.watch is not None:
            node.watch.told = 0
        self._pass(node, Point.START_HANDLING)

    def _report(self, node: Node, event: Reported) -> None:
        """The handler has ended, in one of three ways."""
        # Its end may come before its beginning is told of.
        node.started = node.started or event.time
        self._leave_handler(node)
        if self._had_to_stop(node):
            return
        if event.outcome is Outcome.SUCCESS:
            self._succeed(node, event)
        elif event.outcome is Outcome.FAILURE:
            self._fail(node, _own_failure(node, event.failure))
        elif node.task.on_module_lost != "fail":
            self._restart_elsewhere(node)
        else:
            self._kill(node, "its handler was cancelled by its module")

    def _had_to_stop(self, node: Node) -> bool:
        """Go on with why the handler was being stopped, if it was."""
        if not node.is_alive:
            self._later(self._try_end, node)
        elif node.restarting:
            self._later(self._try_again, node)
        elif node.doomed is not None:
            why, node.doomed = node.doomed, None
            self._fail(node, why)
        elif node.watch is not None and node.watch.expired:
            self._answer(node)
        else:
            return False
        return True

    def _lose(self, node: Node, event: HandlerLost) -> None:
        """The module that had the node is gone."""
        self._leave_handler(node)
        if self._had_to_stop(node):
            return
        if node.task.on_module_lost == "fail":
            text = f"module {event.module!r} was lost while it handled {node.task.name!r}"
            self._fail(node, failure(node, "module_lost", text, module=event.module))
        else:
            self._restart_elsewhere(node)

    def _restart_elsewhere(self, node: Node) -> None:
        """Handle it again: by the next provider, or held until the same module is back."""
        node.only = node.handler if node.task.on_module_lost == "hold" else None
        self._restart(node)

    def _drop(self, node: Node, event: LimitExceeded) -> None:
        """Too many wait for the resource, and the node is the oldest of them."""
        self.pools.drop(node.id, event.resource)
        text = f"more than {event.limit} waited for {event.resource!r}; the oldest was dropped"
        why = failure(node, "pending_limit", text)
        data = {"resource": event.resource, "limit": event.limit}
        self._fail(node, why.model_copy(update={"data": data}))

    def _abandon(self, node: Node) -> None:
        """The handler did not stop in time: go on without it."""
        node.handling = Handling.HANDLED
        self._had_to_stop(node)

    def _leave_handler(self, node: Node) -> None:
        self.pools.release(node.id, node.task.name, node.incarnation or "")
        node.handling = Handling.HANDLED

    def _succeed(self, node: Node, event: Reported) -> None:
        seen = set(event.seen_failures)
        unseen = [(child, why) for child, why in node.failed.items() if child not in seen]
        node.failed.clear()
        if unseen:
            node.result = event.result
            self._fail_by_child(node, unseen[0][1].message or unseen[0][0], unseen[0][1])
        elif node.role is Role.RECOVERY:
            self._resolve(node, event)
        else:
            node.result = event.result
            if node.watch is not None and not node.is_interval_monitor:
                self._test_once(node)
            self._answer(node)

    def _answer(self, node: Node) -> None:
        """Take the node's handler for done, with success."""
        node.answered = True
        if node.watch is not None:
            counts = MonitorReport(satisfied=node.watch.satisfied, fired=node.watch.fired)
            node.result = counts.model_dump(mode="json")
        if node.handling is Handling.UNHANDLED:
            node.handling = Handling.HANDLED
        for point in (Point.START_HANDLING, Point.END_HANDLING, Point.END_ACHIEVING):
            self._later(self._try_point, node, point)

    def _alarm(self, node: Node, key: str) -> None:
        node.alarms.pop(key, None)
        if key == DEADLINE:
            self._miss_deadline(node)
            return
        source = Source("", None, 0.0, key)
        for point in list(node.open):
            self._later(self._released, (node.id, point), source)

    def _miss_deadline(self, node: Node) -> None:
        text = f"{node.task.name!r} was not achieved within {node.task.within:g} s"
        self._doom(node, failure(node, "deadline_passed", text))


def _own_failure(node: Node, told: Failure | None) -> Failure:
    """The failure as its handler reported it, with the facts that central knows."""
    if told is None:
        return failure(node, "failed", f"{node.task.name!r} failed and did not say why")
    facts = {"node": told.node or node.id, "message": told.message or node.task.name}
    return told.model_copy(update={**facts, "module": told.module or node.handler})


def _missing(node: Node) -> Failure:
    return failure(node, "no_handler", f"no module came to handle {node.task.name!r}")
