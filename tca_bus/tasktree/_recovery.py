"""Failures, and the exception handlers that are sought for them up the tree.

Source: TCM's exceptions (search from the failed node to the root, on one node the newest first,
the handler a child of the failed node) with TCA's retry, counted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from tca_bus._attachments import Catch, Caught, Resolution
from tca_bus._failure import Failure
from tca_bus._orders import Point
from tca_bus._protocol import CENTRAL, Handling, SubmitTask, TaskState
from tca_bus.tasktree._constraints import own_edges
from tca_bus.tasktree._endings import Endings
from tca_bus.tasktree._events import (
    CaughtFailure,
    Origin,
    Reported,
    Role,
    UncaughtFailure,
)
from tca_bus.tasktree._node import Node, Recovery
from tca_bus.tasktree._pools import Pools
from tca_bus.tasktree._spawning import HANDLER_PATIENCE

PASSED_OVER = frozenset({"module_lost", "no_handler", "killed"})
"""Failures of an exception handler that say nothing: the search goes on as after a bypass."""

CatchesOf = Callable[[str], Iterable[Catch]]
"""The exception handlers on all tasks of a message, the newest first."""


class Failing(Endings):
    """Lets nodes fail, be repaired and be tried again.

    ``searches`` collects the failing nodes for which a handler is to be sought: the answer comes
    as an event, since it depends on what is attached at that moment.
    """

    def __init__(self, pools: Pools) -> None:
        super().__init__(pools)
        self.searches: list[str] = []
        self.invocations: dict[str, int] = {}

    def find_catch(
        self, time: float, id: str, of_message: CatchesOf
    ) -> CaughtFailure | UncaughtFailure:
        """Seek a handler for the failure of a node, from the node upwards."""
        node = self.nodes[id]
        excluded = self._tried(node)
        for context in [node, *self.ancestors(node)]:
            own = reversed(context.catches.values())
            for catch in [*own, *of_message(context.task.name)]:
                if catch.id not in excluded and self._takes(catch, node.failure):
                    count = self.invocations.get(catch.id, 0) + 1
                    return CaughtFailure(time, id, catch, context.id, count)
        return UncaughtFailure(time, id)

    def _caught(self, node: Node, event: CaughtFailure) -> None:
        """Send the handler that was found, as a child of the failed node."""
        self.invocations[event.catch.id] = event.invocation
        node.recovery = node.recovery or Recovery()
        node.recovery.tried.add(event.catch.id)
        node.recovery.handler = event.catch.handler
        origin = Origin(Role.RECOVERY, node.id, event.catch.id)
        task = SubmitTask(
            id=self._new_id(node, origin),
            name=event.catch.handler,
            task_class="exception",
            data=self._case(node, event).model_dump(mode="json"),
            sender=CENTRAL,
            parent=node.id,
            constraints=0,
            wait_for_handler=HANDLER_PATIENCE,
        )
        self._send_below(node, task, origin)

    def _fail(self, node: Node, why: Failure) -> None:
        if not node.is_alive or node.failing:
            return
        node.failing, node.failure = True, why
        self.touched[node.id] = None
        self.pools.forget(node.id)
        node.passed.pop(Point.START_RECOVERY, None)
        gates = {t.id for t in node.taps.values() if t.condition == "WhenFailure"}
        node.gated -= gates
        self._later(self._try_point, node, Point.START_RECOVERY)

    def _seek(self, node: Node) -> None:
        """Look for a handler; what was offered further down already is not offered again."""
        if node.failure is not None and node.failure.uncaught:
            self._give_up(node)
        else:
            self.searches.append(node.id)

    def _give_up(self, node: Node) -> None:
        why = node.failure
        if why is not None and node.is_alive:
            self._terminate(node, TaskState.FAILED, why.model_copy(update={"uncaught": True}))
            self._kill_below(node, "its parent failed")

    def _takes(self, catch: Catch, why: Failure | None) -> bool:
        spent = self.invocations.get(catch.id, 0)
        is_left = not catch.max_invocations or spent < catch.max_invocations
        return is_left and why is not None and why.is_a(catch.exception)

    def _tried(self, node: Node) -> set[str]:
        """The handlers that had this failure, or are at work on one above it."""
        found = set(node.recovery.tried) if node.recovery else set()
        for above in [node, *self.ancestors(node)]:
            parent = self.parent(above)
            if above.role is Role.RECOVERY and parent is not None and parent.recovery:
                found |= parent.recovery.tried
        return found

    def _case(self, node: Node, event: CaughtFailure) -> Caught:
        context = self.nodes[event.context]
        why = node.failure.model_dump(mode="json") if node.failure else {}
        return Caught(
            failure=why,
            failed=node.id,
            failed_name=node.task.name,
            failed_data=node.task.data,
            context=context.id,
            context_name=context.task.name,
            retries=node.retries,
            context_retries=context.retries,
            invocation=event.invocation,
        )

    def _resolve(self, handler: Node, event: Reported) -> None:
        """An exception handler has succeeded: repair at once, the rest when its node has ended."""
        node = self.parent(handler)
        decision = event.resolution or Resolution()
        if node is not None and node.failing and node.recovery is not None:
            node.recovery.decision = decision
            if decision.action == "repaired":
                self._repair(node, event.result)
        handler.result = event.result
        self._answer(handler)

    def _repair(self, node: Node, result: object) -> None:
        """Take the failed node for done, whatever it was doing."""
        node.failing, node.failure, node.recovery = False, None, None
        node.failed.clear()
        if result is not None:
            node.result = result
        self._answer(node)

    def _recovery_ended(self, node: Node, handler: Node) -> None:
        if not node.is_alive or not node.failing or node.recovery is None:
            return
        decision, node.recovery.decision = node.recovery.decision, None
        why = handler.failure
        if handler.fate is TaskState.FAILED and why is not None and why.name not in PASSED_OVER:
            self._raise_another(node, why)
        elif decision is not None and decision.action == "retry" and self._retries(node, decision):
            return
        else:
            self.searches.append(node.id)

    def _raise_another(self, node: Node, why: Failure) -> None:
        """The handler failed itself, with a failure that nobody takes either."""
        last = why.chain()[-1]
        if last.node != node.id:
            links = [*why.chain(), *(node.failure.chain() if node.failure else [])]
            why = _chained(links)
        node.failure = why
        self._give_up(node)

    def _retries(self, node: Node, decision: Resolution) -> bool:
        """Run the failed node or one above it again; False when it was run again often enough."""
        target = node if decision.task is None else self.nodes.get(decision.task)
        allowed = {node.id, *(above.id for above in self.ancestors(node))}
        if target is None or target.id not in allowed or not target.is_alive:
            return False
        if target.retries >= decision.most:
            return False
        self._restart(target, is_retry=True)
        return True

    def _restart(self, node: Node, *, is_retry: bool = False) -> None:
        """Make the node ready for another try; what the last try began below it is killed."""
        if not node.is_alive or node.restarting:
            return
        self.touched[node.id] = None
        node.retries += is_retry
        node.restarting, node.answered, node.failing = True, False, False
        node.doomed = node.failure = node.result = node.recovery = None
        node.failed.clear()
        node.gated.clear()
        self.pools.forget(node.id)
        self._stop(node, "it is handled again")
        self._kill_below(node, "its parent is handled again")
        self._later(self._try_again, node)

    def _try_again(self, node: Node) -> None:
        if not node.restarting or node.alive or node.is_handling:
            return
        node.restarting = False
        node.handling, node.handler, node.incarnation = Handling.UNHANDLED, None, None
        node.taken, node.started = False, None
        for point in (
            Point.START_HANDLING,
            Point.END_HANDLING,
            Point.START_RECOVERY,
            *((Point.END_PLANNING,) if node.is_goal else ()),
        ):
            node.passed.pop(point, None)
        for first, then in own_edges(node):
            if first[1] not in node.passed:
                self._connect(first, then)
        self._try_ready(node)


def _chained(links: list[Failure]) -> Failure:
    """One failure with the others as its causes, in order."""
    chain: Failure | None = None
    for link in reversed(links):
        chain = link.model_copy(update={"cause": chain})
    if chain is None:
        raise ValueError("links: expected at least one failure")
    return chain
