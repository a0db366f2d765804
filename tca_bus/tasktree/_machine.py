"""The transitions of the nodes: what each event does, until nothing more follows."""

from __future__ import annotations

from tca_bus._attachments import Catch, CleanUp, Tap, TapCondition
from tca_bus._failure import Failure
from tca_bus._monitor_spec import Condition, MonitorReport
from tca_bus._orders import Point
from tca_bus._protocol import Constraint, Handling, Outcome, SubmitTask
from tca_bus.tasktree._constraints import (
    delayed_edges,
    flags_of,
    own_edges,
    parent_edges,
    sibling_edges,
)
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
    Origin,
    Prepared,
    Prioritized,
    Released,
    Reported,
    Resumed,
    Retried,
    Role,
    Submitted,
    Suspended,
    Taken,
    Triggered,
    UncaughtFailure,
)
from tca_bus.tasktree._node import DEADLINE, Node, Source, Watch
from tca_bus.tasktree._recovery import Failing

STARTS = (Point.START_PLANNING, Point.START_ACHIEVING, Point.START_HANDLING)


class Machine(Failing):
    """The nodes and their transitions. Each public method is one event on one node."""

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

    def is_suspended(self, node: Node) -> bool:
        """Whether the node or one above it is suspended; a clean-up is not by those above."""
        for each in [node, *self.ancestors(node)]:
            if each.suspended:
                return True
            if each.role is Role.CLEAN_UP:
                return False
        return False

    def attach(self, node: Node, what: Tap | Catch | CleanUp) -> None:
        """Attach something to a node; of one id there is one."""
        match what:
            case Tap():
                node.taps[what.id] = what
            case Catch():
                node.catches[what.id] = what
            case CleanUp():
                node.clean_ups[what.id] = what

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

    def _try_ready(self, node: Node) -> None:
        if not node.is_ready or self.is_suspended(node):
            return
        if self._is_gated(node, Point.START_HANDLING):
            return
        self.touched[node.id] = None
        name, rank, sender = node.task.name, self._rank(node), node.task.sender
        self.pools.wait(node.id, name, rank, only=node.only, sender=sender)

    def _rank(self, node: Node) -> tuple[int, int]:
        """The priority of the whole task, then that of the node in it."""
        top = self.nodes[node.root]
        return top.priority, node.priority if node is not top else 0

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

    def _look_again(self, node: Node) -> None:
        """What waits for its handler may have to wait for something else now."""
        if node.handling is Handling.UNHANDLED:
            self.pools.forget(node.id)
            self._later(self._try_ready, node)

    def _suspend(self, node: Node) -> None:
        node.suspended = True
        for each in self.below(node.id):
            self.touched[each.id] = None
            self.pools.forget(each.id)

    def _resume(self, node: Node) -> None:
        node.suspended = False
        for each in self.below(node.id):
            self.touched[each.id] = None
            self._later(self._try_ready, each)

    def _prioritize(self, node: Node, priority: int) -> None:
        """Put what waits in order again, by age too: of a top-level task, all that is below it."""
        node.priority = priority
        waiting = self.below(node.id) if node.id == node.root else [node]
        for each in waiting:
            self.pools.reprioritise(each.id, self._rank(each))

    def _detach(self, node: Node, attachment: str) -> None:
        node.catches.pop(attachment, None)
        node.clean_ups.pop(attachment, None)
        if node.taps.pop(attachment, None) is None:
            return
        for id in list(node.alive):
            child = self.nodes.get(id)
            if child is not None and child.origin.attachment == attachment:
                self._later(self._kill, child, "its tap was removed")


def _own_failure(node: Node, told: Failure | None) -> Failure:
    """The failure as its handler reported it, with the facts that central knows."""
    if told is None:
        return failure(node, "failed", f"{node.task.name!r} failed and did not say why")
    facts = {"node": told.node or node.id, "message": told.message or node.task.name}
    return told.model_copy(update={**facts, "module": told.module or node.handler})


def _missing(node: Node) -> Failure:
    return failure(node, "no_handler", f"no module came to handle {node.task.name!r}")
