"""One run of PRODIGY: plan, execute, take in what arrives, until nothing is left to do."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable, Collection, Coroutine, Iterable, Mapping, Sequence

from rogue import trace
from rogue.admission import choose
from rogue.conversation import Conversation
from rogue.decisions import DecisionRecorder
from rogue.distances import Distances
from rogue.errands import Agenda, ListWatcher
from rogue.execution import Executor
from rogue.memory import Store
from rogue.messages import DeliveryRequest, MonitorView, PlanView, RequestState
from rogue.outcomes import StepOutcome
from rogue.planning import (
    NODES_OF_A_REQUEST,
    NODES_OF_A_SEARCH,
    Rules,
    admit,
    claim,
    correct,
    errand,
    new_search,
    report,
    switches,
    withdraw,
)
from rogue.prodigy import (
    Announced,
    Decided,
    Event,
    Execute,
    Executed,
    Failed,
    Finished,
    GoalTree,
    Literal,
    Poll,
    PollPoint,
    Search,
    SearchResult,
    Status,
    goal_tree,
)
from rogue.requests import Directory, RequestBook

log = logging.getLogger(__name__)

MOST_SHOWN = 1000
"""Goals and operators of a plan that is shown, and as many of those that came to nothing."""

Locations = Mapping[str, tuple[float, float]]


class Episode:
    """A search over the requests that are open, and those that come while it runs.

    ``servable`` gives the open requests that can be gone on with now, the oldest first;
    ``told`` are the ids of the requests whose arrival the conversation has told already,
    ``level`` is that of the planner's trace.
    """

    def __init__(
        self,
        *,
        rules: Rules,
        locations: Locations,
        directory: Directory,
        distances: Distances,
        agenda: Agenda,
        store: Store,
        book: RequestBook,
        executor: Executor,
        conversation: Conversation,
        decisions: DecisionRecorder,
        servable: Callable[[], list[DeliveryRequest]],
        told: set[str],
        level: int = 2,
    ) -> None:
        self._rules = rules
        self._locations = locations
        self._directory = directory
        self._distances = distances
        self._store = store
        self._book = book
        self._executor = executor
        self._conversation = conversation
        self._decisions = decisions
        self._servable = servable
        self._told = told
        self._level = level
        self._agenda = agenda
        self._switches = switches(rules, agenda)
        self._admitted: dict[str, DeliveryRequest] = {}
        self._measured: set[str] = set()
        self._seen: list[str] = []
        self._unranked: list[DeliveryRequest] = []
        self._lines: list[str] = []
        self._executed: list[str] = []
        self._search: Search | None = None
        self._lists = ListWatcher() if rules is Rules.Y1998 else None
        self._admitting = asyncio.Lock()

    def view(self, *, planning: bool, monitors: list[MonitorView]) -> PlanView:
        """The search as it stands, and what is watched for it."""
        tree = goal_tree(self._search) if self._search is not None else GoalTree()
        return PlanView(
            planning=planning,
            nodes=self._lines,
            executed=self._executed,
            tree=tree.pruned(most_live=MOST_SHOWN, most_gone=MOST_SHOWN),
            monitors=monitors,
        )

    async def run(self) -> None:
        """Plan and execute until every admitted request has ended."""
        first = sorted(self._wanted(), key=lambda request: -request.rank)
        for request in first:
            await self._take_in(request)
        search = new_search(
            first,
            self._executor.world.facts,
            directory=self._directory,
            rooms=self._locations,
            switches=self._switches,
            level=self._level,
        )
        self._search = search
        result = await self._drive(search)
        await self._conclude(result)

    async def _drive(self, search: Search) -> SearchResult:
        while (event := search.step()) is not None:
            if isinstance(event, Decided | Failed):
                self._decisions.see(event)
            match event:
                case Announced() | Failed() | Executed():
                    await self._show(search.trace)
                    await self._tell_lists(search, event)
                case Execute():
                    await self._tell_lists(search, event)
                    await self._execute(search, event)
                case Poll(nodes=nodes):
                    await self._poll(search)
                    self._stop_if_long(search, nodes)
                case Finished(result=result):
                    return result
            await asyncio.sleep(0)
        raise AssertionError("a search ends with Finished")

    async def _show(self, printed: Sequence[str]) -> None:
        """Say the lines that are new, and once more those to which something was added."""
        shown = self._lines
        self._lines = list(printed)
        for number, line in enumerate(printed):
            if number >= len(shown) or shown[number] != line:
                await self._conversation.tell(line)

    async def _tell_lists(self, search: Search, event: Event | None = None) -> None:
        """Say pending goals, applicable and executed operators, as the 1998 example does."""
        lists = self._lists
        if lists is None:
            return
        moment = lists.observe(search, event) if event else lists.goals_changed(search)
        if moment is not None:
            lines = [trace.remark(line) for line in moment.lists.lines()]
            await self._conversation.tell_all(["", *lines, ""])

    async def _execute(self, search: Search, event: Execute) -> None:
        step = event.step
        arguments = [str(value) for value in step.args]
        await self._suspend_others()
        log.info("executing %s", step)
        work = self._executor.execute(step.operator, arguments, list(self._admitted))
        outcome = await self._open_to_arrivals(search, work)
        if outcome.kind == "done":
            self._executed.append(str(step))
        report(search, outcome, self._executor.world.facts, self._switches)

    async def _open_to_arrivals(
        self, search: Search, work: Coroutine[object, object, StepOutcome]
    ) -> StepOutcome:
        """Wait for a step; requests enter the search meanwhile, where its options allow that."""
        if self._switches.options.poll is not PollPoint.BEFORE_EXPANSION:
            return await work
        arrivals = asyncio.create_task(self._take_in_arrivals(search), name="rogue.arrivals")
        try:
            return await work
        finally:
            await self._close_to_arrivals(arrivals)

    async def _close_to_arrivals(self, arrivals: asyncio.Task[None]) -> None:
        """End taking in requests, but none halfway."""
        try:
            async with self._admitting:
                pass
        finally:
            arrivals.cancel()
        await asyncio.wait([arrivals])
        if not arrivals.cancelled():
            arrivals.result()

    async def _take_in_arrivals(self, search: Search) -> None:
        while True:
            self._book.changed.clear()
            await self._book.changed.wait()
            # In lockstep the robot does not drive on before the search knows.
            with self._book.clock.hold():
                async with self._admitting:
                    await self._admit_new(search, self._wanted())

    async def _poll(self, search: Search) -> None:
        await self._learn_distances()
        correct(search, self._executor.world.facts, self._switches)
        self._drop_changed(search)
        await self._drop_ended(search)
        wanted = self._wanted()
        await self._leave_out(search, {request.id for request in wanted})
        await self._admit_new(search, wanted)

    async def _admit_new(self, search: Search, wanted: Iterable[DeliveryRequest]) -> None:
        for request in wanted:
            if request.id not in self._admitted:
                others = list(self._admitted.values())
                await self._take_in(request)
                admit(search, request, others, self._switches)
        if self._unranked:
            await self._conversation.tell_all(trace.priority_lines(self._unranked))
            self._unranked.clear()
        await self._tell_lists(search)

    def _stop_if_long(self, search: Search, nodes: int) -> None:
        """End a search that users keep alive, so that its tree does not grow for ever."""
        expected = NODES_OF_A_REQUEST * len(self._admitted)
        if self._executed and nodes > NODES_OF_A_SEARCH + expected:
            search.stop("the tree has grown large")

    def _drop_changed(self, search: Search) -> None:
        """Take out what is put off, and what goes on otherwise; it enters again as it is then.

        What else is new of a request, such as its deadline, counts from now on.
        """
        for request_id, request in list(self._admitted.items()):
            now = self._book.find(request_id)
            if now is None:
                continue
            if self._executor.world.waits(now) or errand(now) != errand(request):
                self._withdraw(search, request)
            elif now != request:
                self._admitted[request_id] = now
                self._agenda.put(claim(now, self._directory))

    async def _leave_out(self, search: Search, wanted: Collection[str]) -> None:
        """Take out what others are more urgent than, and what finds no place on the tray."""
        servable = {request.id for request in self._servable()}
        for request_id, request in list(self._admitted.items()):
            if request_id not in wanted:
                self._withdraw(search, request)
                has_place = request_id in servable
                reason = "others are more urgent" if has_place else "what is put off fills the tray"
                await self._book.suspend(request_id, reason)

    async def _suspend_others(self) -> None:
        """Say which errands under way are put aside for those that are served now."""
        advice = self._switches.advice
        if advice is None:
            return
        put_aside = advice.latest.put_aside
        for request in self._admitted.values():
            if (request.user, request.item) in put_aside:
                await self._book.suspend(request.id, "it is put aside for what is more urgent")

    def _withdraw(self, search: Search, request: DeliveryRequest) -> None:
        del self._admitted[request.id]
        self._decisions.withdraw(request.id)
        withdraw(search, request, self._admitted.values(), self._switches)

    async def _drop_ended(self, search: Search) -> None:
        for request_id, request in list(self._admitted.items()):
            if self._book.find(request_id) is not None:
                continue
            del self._admitted[request_id]
            self._decisions.withdraw(request_id)
            ended = await self._store.request(request_id)
            goal = self._switches.goal(errand(request))
            if ended is None or (
                ended.state is RequestState.COMPLETED and search.state.holds(goal)
            ):
                continue
            said = f"Request {ended.id} is {ended.state.value}: {ended.reason}"
            await self._conversation.tell_all([trace.remark(said), ""])
            withdraw(search, request, self._admitted.values(), self._switches)

    async def _take_in(self, request: DeliveryRequest) -> None:
        self._admitted[request.id] = request
        await self._learn_distances()
        self._agenda.put(claim(request, self._directory))
        self._decisions.admit(request)
        self._seen.append(request.id)
        self._unranked.append(request)
        if request.id not in self._told and request.state is RequestState.QUEUED:
            self._told.add(request.id)
            await self._conversation.tell_all(["", trace.message_line(request)])

    async def _learn_distances(self) -> None:
        """Find out how far it is between the rooms of all errands, and from where the robot is."""
        rooms = {room for r in self._admitted.values() for room in (r.pickup, r.deliver)}
        if (here := self._executor.world.facts.room) is not None:
            rooms.add(here)
        if not rooms <= self._measured:
            self._measured = rooms
            await self._distances.learn(rooms, self._locations)

    def _wanted(self) -> list[DeliveryRequest]:
        """Open requests that should be in the search, no two that PRODIGY could not tell apart."""
        free = self._servable()
        tray = self._executor.world.facts.tray
        begun = [r for r in free if r.state is not RequestState.QUEUED]
        return choose(
            free,
            begun={r.id for r in begun},
            pinned={r.id for r in begun if (r.user, r.item) in tray},
            priority=self._priority,
            identity=self._identity,
        )

    def _priority(self, request: DeliveryRequest) -> float:
        return self._agenda.priority_of(claim(request, self._directory))

    def _identity(self, request: DeliveryRequest) -> tuple[str, ...]:
        if self._rules.one_errand_a_person:
            return (request.user,)
        return (request.user, request.item)

    async def _conclude(self, result: SearchResult) -> None:
        """Say how it ended; what the planner could not do has failed."""
        left = [r for r in self._admitted if self._book.find(r) is not None]
        hopeless = [r for r in left if self._goal(r) in result.hopeless]
        if result.status is Status.SOLVED and not left:
            if await self._completed_any():
                await self._conversation.tell_all([trace.ACHIEVED, ""])
        elif self._executed and not hopeless:
            # What was driven stays driven: the next episode plans on from here.
            log.info("search ended with %s: %s", result.status, result.reason)
        else:
            reason = f"no plan was found ({result.status}: {result.reason})"
            await self._fail(hopeless or left, reason)

    def _goal(self, request_id: str) -> Literal:
        return self._switches.goal(errand(self._admitted[request_id]))

    async def _completed_any(self) -> bool:
        ended = [await self._store.request(request_id) for request_id in self._seen]
        return any(r is not None and r.state is RequestState.COMPLETED for r in ended)

    async def _fail(self, request_ids: Iterable[str], reason: str) -> None:
        for request_id in request_ids:
            request = self._book.find(request_id)
            if request is not None and await self._book.end(request, RequestState.FAILED, reason):
                await self._conversation.tell_all([trace.remark(f"{request_id}: {reason}"), ""])
