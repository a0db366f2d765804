"""Central: the task tree on the bus, with its journal.

A thin shell: what comes in becomes an event of the tree; its effects are carried out after the
events are in the journal, in the order in which they came.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import os
import time
from collections import OrderedDict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Self

from tca_bus._central_absences import LOST_AFTER, Absences
from tca_bus._central_alarms import Alarms
from tca_bus._central_cards import introduction
from tca_bus._central_desk import Desk
from tca_bus._central_post import Post
from tca_bus._central_resources import ResourceDesk
from tca_bus._central_steering import SteeringDesk
from tca_bus._central_variables import VariableDesk
from tca_bus._errors import NoHandlerError, RefusedError, TcaError, TimedOutError
from tca_bus._journal import Journal, JournalError
from tca_bus._module import Module
from tca_bus._options import BusOptions
from tca_bus._permissions import Permissions
from tca_bus._policy import Policy
from tca_bus._presence import PresentModule
from tca_bus._protocol import Describe, ModuleCard, SubmitTask, TaskStatus
from tca_bus.tasktree import (
    Cancel,
    Dispatch,
    Effect,
    Ended,
    Event,
    Freed,
    HandlerMissing,
    ProviderAppeared,
    ProviderLost,
    Publish,
    Record,
    SetAlarm,
    Taken,
    Tell,
    Tree,
    WaitForHandler,
)

logger = logging.getLogger(__name__)

NAME = "central"

RETURN_GRACE = 3.0
"""Wall seconds after its start until central takes modules that it does not see for lost."""

UNHURRIED = 0.02
"""Wall seconds that what nobody waits for may take to be written and told."""

INTRODUCTION_DELAY = 1.0
"""Wall seconds before a module is asked again to introduce itself."""

MOST_RECENT = 1000
"""Last statuses of ended nodes that are kept at hand for late viewers."""


@dataclass(slots=True)
class _Batch:
    """The effects of one event, and who waits for them to be carried out."""

    effects: list[Effect]
    done: asyncio.Future[None] = field(
        default_factory=lambda: asyncio.get_running_loop().create_future()
    )


class Central:
    """The keeper of the task tree: an async context manager, one per realm.

    Args:
        options: How to join the bus.
        data: The folder of ``central.db``; None keeps the journal in memory.
        lost_after: Wall seconds for which a module may be out of reach before its tasks are
            given up, as the ``on_module_lost`` of each says.
        on_end: Called with the last status of each node, once it is in the journal and at most
            once, also over restarts.
        policy: Who may do what; None takes the router's, if it has one.

    Raises:
        RefusedError: on entering, there is a central on the realm already.
        ConfigError: on entering, the journal cannot be used.
        BusGoneError: on entering, there is no router.
    """

    def __init__(
        self,
        options: BusOptions | None = None,
        *,
        data: Path | None = None,
        lost_after: float = LOST_AFTER,
        on_end: Callable[[TaskStatus], None] = lambda _: None,
        policy: Policy | None = None,
    ) -> None:
        self.options = options or BusOptions()
        self.module = Module(NAME, options=self.options)
        self.permissions = self.module.permissions = Permissions(policy)
        self.journal = Journal(data / "central.db" if data is not None else None)
        self.tree = Tree()
        self.recent: OrderedDict[str, TaskStatus] = OrderedDict()
        self.ready = asyncio.Event()
        self._on_end = on_end
        self._post = Post(self)
        self._alarms = Alarms(self)
        self._desk = Desk(self)
        self._steering = SteeringDesk(self)
        self.resources = ResourceDesk(self)
        self._variables = VariableDesk(self.module, self.journal)
        self._batches: list[_Batch] = []
        self._wake = asyncio.Event()
        self._settled_at = 0.0
        self._lost_after = lost_after
        self._absences = Absences(self, lost_after=lost_after)
        self._changed = asyncio.Event()
        self._described: set[PresentModule] = set()

    async def __aenter__(self) -> Self:
        await refuse_second(self.options)
        await self.journal.__aenter__()
        try:
            self._desk.serve(self.module)
            self._steering.serve(self.module)
            self.resources.serve(self.module)
            self._variables.serve()
            await self.module.__aenter__()
        except BaseException:
            await self.journal.__aexit__(None, None, None)
            raise
        try:
            await self._begin()
        except BaseException as error:
            await self.__aexit__(type(error), error, error.__traceback__)
            raise
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            await self.module.__aexit__(kind, error, trace)
        finally:
            await self.journal.__aexit__(kind, error, trace)

    async def serve_forever(self) -> None:
        """Serve until cancelled.

        Raises:
            JournalError: The journal cannot be written any more.
        """
        await self.module.serve_forever()

    def happen(self, event: Event) -> asyncio.Future[None]:
        """Let an event happen; the future is done when it is in the journal.

        Raises:
            RefusedError: The tree will not have it.
        """
        # That a handler has begun is worth no commit of its own: its end often comes at once.
        is_urgent = not isinstance(event, Taken)
        done = self._enqueue(self.tree.apply(event), is_urgent=is_urgent)
        self._changed.set()
        self._changed = asyncio.Event()
        self.resources.tree_changed()
        return done

    def now(self) -> float:
        """The time of central's clock; the epoch while simulated time is not known yet."""
        try:
            return self.module.clock.now()
        except TimedOutError:
            return 0.0

    async def committed(self) -> None:
        """Wait until all that happened so far is in the journal."""
        await self.ready.wait()
        await self._enqueue([])

    async def admit(self, task: SubmitTask) -> None:
        """Refuse a task that cannot be; shortly after a start a missing module may still come.

        Raises:
            RefusedError: See `Tree.check`.
            NoHandlerError: Nobody handles it and it may not wait.
        """
        while True:
            try:
                self.tree.check(task)
            except NoHandlerError:
                left = self._settled_at - time.monotonic()
                if left <= 0:
                    raise
                with contextlib.suppress(TimeoutError):
                    async with asyncio.timeout(left):
                        await self._changed.wait()
            else:
                return

    def status(self, id: str) -> TaskStatus | None:
        """The status of a node that is alive or ended not long ago."""
        return self.tree.status(id) if id in self.tree else self.recent.get(id)

    def lookup(self, sender: str, id: str) -> Sequence[TaskStatus]:
        """The statuses at hand, of one sender and id or of all (``*``)."""
        if id != "*":
            status = self.status(id)
            found = [status] if status is not None else []
        else:
            found = [*self.recent.values(), *self.tree.statuses()]
        return [status for status in found if sender in {"*", status.sender}]

    def _enqueue(self, effects: list[Effect], *, is_urgent: bool = True) -> asyncio.Future[None]:
        self._remember(effects)
        batch = _Batch(effects)
        self._batches.append(batch)
        if is_urgent:
            self._wake.set()
        else:
            asyncio.get_running_loop().call_later(UNHURRIED, self._wake.set)
        return batch.done

    async def _begin(self) -> None:
        self._refuse_younger()
        self.tree = Tree(generation=self.journal.generation - 1)
        effects = await self._replay()
        self._settled_at = time.monotonic() + RETURN_GRACE
        self.module.serve_statuses(self.lookup)
        self.module.start(self._write_batches(), name="central.journal")
        self._alarms.begin()
        self._enqueue(effects)
        await self.resources.begin()
        self._welcome_modules()
        self.module.start(self._watch_modules(), name="central.presence")
        self.module.start(self._settle(), name="central.settle")
        await self._variables.begin()
        self.ready.set()
        if len(self.tree):
            logger.info("goes on with %d task nodes from the journal", len(self.tree))

    async def _replay(self) -> list[Effect]:
        events = await self.journal.living_events()
        try:
            return self.tree.replay(events)
        except (RefusedError, KeyError) as error:
            raise JournalError(self.journal.name, f"its events do not fit: {error}") from error

    def _refuse_younger(self) -> None:
        """Of two centrals that started at once, or apart and met, the older stays."""
        others = [m for m in self.module.modules() if m.name == NAME]
        oldest = min(others, key=lambda module: module.incarnation)
        if oldest.incarnation != self.module.incarnation:
            raise second_central(self.options.realm, oldest)

    async def _settle(self) -> None:
        """Give modules that were here before time to announce themselves to this central."""
        await asyncio.sleep(max(RETURN_GRACE, self._lost_after))
        await self.module.connected()
        present = {module.incarnation for module in self.module.modules()}
        for incarnation in set(self.tree.holders()) - present - self._absences.awaited():
            self._part_with(incarnation)
        self.resources.keep_only(present | self._absences.awaited())

    async def _watch_modules(self) -> None:
        async with self.module.watch_modules() as changes:
            async for change in changes:
                self._absences.presence_changed()
                if change.appeared:
                    if change.module.name == NAME:
                        self._refuse_younger()
                    self._welcome_modules()
                else:
                    self._described.discard(change.module)
                    name = f"central.absence.{change.module.name}"
                    self.module.start(self._bear_absence(change.module), name=name)

    def _welcome_modules(self) -> None:
        present = set(self.module.modules())
        self._described &= present
        for module in sorted(present - self._described, key=lambda m: m.incarnation):
            self._described.add(module)
            if not module.provides or module.name == NAME:
                continue
            capacities = dict.fromkeys(module.provides, 1)
            unknown = ProviderAppeared(
                self.now(), module.name, module.incarnation, capacities, is_introduced=False
            )
            self.happen(unknown)
            for predecessor in self._absences.predecessors(module):
                self._part_with(predecessor, module.name)
            self.module.start(self._get_to_know(module), name=f"central.describe.{module.name}")

    async def _get_to_know(self, module: PresentModule) -> None:
        """Have a module introduce itself, however long it takes."""
        while module in self.module.modules():
            try:
                card = await self.module.query(Describe(), to=module)
            except TcaError as error:
                logger.warning("module %s does not introduce itself: %s", module.name, error)
                await asyncio.sleep(INTRODUCTION_DELAY)
            else:
                self._take_card(module, card)
                return

    def _take_card(self, module: PresentModule, card: ModuleCard) -> None:
        """Note how many tasks a module handles at once; it stops those it was relieved of."""
        if module not in self.module.modules():
            return
        known = [told for told in card.provides if told.name in module.provides]
        card = card.model_copy(update={"provides": known})
        self.happen(introduction(self.now(), module, card))
        for taken in card.handling:
            if not self.tree.is_current(taken.id, taken.attempt):
                self._post.recall(taken.id, taken.attempt, module.incarnation)

    async def _bear_absence(self, module: PresentModule) -> None:
        if not await self._absences.outlast(module):
            self._part_with(module.incarnation, module.name)

    def _part_with(self, incarnation: str, module: str = "") -> None:
        name = self.tree.holders().get(incarnation)
        if name is not None:
            logger.warning("module %s is gone", name)
        self.happen(ProviderLost(self.now(), incarnation, name or module))
        self.resources.module_gone(incarnation)

    async def _write_batches(self) -> None:
        """Write all that came since the last commit in one transaction, then act on it."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            batches, self._batches = self._batches, []
            if not batches:
                continue
            effects = [effect for batch in batches for effect in batch.effects]
            await self._write(effects)
            news = newest(effects)
            self._publish(status for status in news if status.is_ended)
            for status in news:
                self.resources.task_changed(status)
            self._carry_out(effects)
            for batch in batches:
                if not batch.done.done():
                    batch.done.set_result(None)
            # Handlers and who waits for the commit come before those who only look on.
            await asyncio.sleep(0)
            self._publish(status for status in news if not status.is_ended)

    async def _write(self, effects: list[Effect]) -> None:
        records = [effect for effect in effects if isinstance(effect, Record)]
        freed = [effect for effect in effects if isinstance(effect, Freed)]
        ended = [effect for effect in effects if isinstance(effect, Ended)]
        if records or ended:
            await self.journal.write(records, freed, ended)

    def _remember(self, effects: list[Effect]) -> None:
        for effect in effects:
            if isinstance(effect, Freed):
                self.recent[effect.status.id] = effect.status
        while len(self.recent) > MOST_RECENT:
            self.recent.popitem(last=False)

    def _publish(self, statuses: Iterable[TaskStatus]) -> None:
        for status in statuses:
            self.module.publish_status(status)
            if status.is_ended:
                self._on_end(status)

    def _carry_out(self, effects: list[Effect]) -> None:
        for effect in effects:
            match effect:
                case Dispatch():
                    self._post.dispatch(effect)
                case Cancel():
                    self._post.cancel(effect)
                case Tell():
                    self._post.tell(effect)
                case SetAlarm():
                    self._alarms.add(effect)
                case WaitForHandler():
                    self.module.start(self._wait(effect), name=f"central.wait.{effect.id}")
                case _:
                    pass

    async def _wait(self, wait: WaitForHandler) -> None:
        await asyncio.sleep(wait.seconds)
        if self.tree.is_missing(wait.id, wait.number):
            self.happen(HandlerMissing(self.now(), wait.id))


def newest(effects: Iterable[Effect]) -> list[TaskStatus]:
    """The last status of each node in effects: what came before it nobody has seen yet."""
    found = {one.status.id: one.status for one in effects if isinstance(one, Publish)}
    return list(found.values())


async def refuse_second(options: BusOptions) -> None:
    """Look for a central before one is started; one that just died has a moment to vanish.

    Raises:
        RefusedError: There is one.
        BusGoneError: There is no router.
    """
    async with Module(f"{NAME}-{os.getpid()}", options=options) as scout:
        deadline = time.monotonic() + RETURN_GRACE
        while (other := next((m for m in scout.modules() if m.name == NAME), None)) is not None:
            if time.monotonic() > deadline:
                raise second_central(options.realm, other)
            await asyncio.sleep(0.05)


def second_central(realm: str, other: PresentModule) -> RefusedError:
    """The error that a second central ends with."""
    why = (
        f"process {other.pid} on {other.host} is central there; stop it, or choose another "
        "realm with --realm"
    )
    return RefusedError(f"a second central on realm {realm!r}", why)
