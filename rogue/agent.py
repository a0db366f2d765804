"""The ROGUE agent: accepts requests, plans for them, and has the robot carry the plans out.

Source: Haigh & Veloso, *Interleaving planning and robot execution for asynchronous user
requests* (1996, 1998).
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import Coroutine, Iterable
from dataclasses import dataclass, field
from pathlib import Path

from rogue import trace
from rogue.admission import servable
from rogue.conversation import Conversation
from rogue.decisions import DecisionRecorder
from rogue.distances import Distances
from rogue.episode import Episode, Locations
from rogue.errands import Agenda, Metric, MetricError, RankSum, Travel, guarded
from rogue.execution import (
    BusRobot,
    Endurance,
    Executor,
    KnownWorld,
    Patience,
    StepRunner,
    Verification,
    as_published,
    layered,
)
from rogue.memory import Store
from rogue.messages import DeliveryRequest, MonitorView, PlanView, RequestState, ShowPlan
from rogue.monitors import MonitorRegistry, office_monitors
from rogue.planning import Rules
from rogue.requests import (
    Desk,
    Directory,
    FingerServer,
    Prospects,
    Questions,
    Reception,
    RequestBook,
    load_directory,
    reread_on_hangup,
)
from rogue.times import show_time
from tca_bus import BusOptions, Context, Module

log = logging.getLogger(__name__)

CLOCK_WAIT = 60.0
"""Wall seconds until the time of the world must be known."""


PLACES = 6
"""Items for which the tray has room."""


@dataclass(frozen=True)
class AgentOptions:
    """How the agent works.

    ``folder`` is where it keeps what it must not forget; ``directory`` is a file with people and
    items, None for the one of the package; ``finger`` is a server that is asked for what no
    directory says, None for no such server. The rest is for the working rules: ``metric`` gives
    priorities, ``places`` is how many items the tray holds, None for any number, and ``arrival``
    is how arrivals are verified; the published rules always ask a person. ``level`` is that of
    the planner's trace: 2 nodes, 3 also the rules that decided.
    """

    folder: Path
    rules: Rules = Rules.WORKING
    directory: Path | None = None
    finger: FingerServer | None = None
    level: int = 2
    metric: Metric = field(default_factory=RankSum)
    places: int | None = PLACES
    patience: Patience = field(default_factory=Patience)
    endurance: Endurance = field(default_factory=Endurance)
    arrival: Verification = field(default_factory=layered)

    @property
    def tray(self) -> int | None:
        """Items for which the tray has room; the published rules know of no bound."""
        return self.places if self.rules is Rules.WORKING else None

    @property
    def verification(self) -> Verification:
        """How arrivals are verified."""
        return self.arrival if self.rules is Rules.WORKING else as_published()


class Agent:
    """The rogue module's work, over an open store; `run_agent` makes one and runs it."""

    def __init__(
        self, module: Module, store: Store, directory: Directory, options: AgentOptions
    ) -> None:
        self._module = module
        self._store = store
        self._directory = directory
        self._options = options
        self._conversation = Conversation(module, store)
        self._robot = BusRobot(module, options.endurance)
        self._book = RequestBook(module, store, directory)
        self._reception = Reception(
            store=store,
            directory=directory,
            questions=Questions(module, store, self._conversation),
            server=options.finger,
        )
        self._world = KnownWorld(store, module)
        self._distances = Distances(module)
        travel = Travel(distance=self._distances, capacity=options.places)
        self._prospects = Prospects(
            module=module, store=store, book=self._book, travel=travel, learn=self._learn
        )
        self._agenda = Agenda(
            travel=travel,
            metric=guarded(options.metric, _complain),
            now=self._now,
        )
        self._monitors: MonitorRegistry | None = None
        self._locations: Locations = {}
        self._episode: Episode | None = None
        self._planning = False
        self._told: set[str] = set()

    def open_desk(self) -> None:
        """Register the handlers of the module; before it joins the bus."""
        desk = Desk(self._module, self._store, self._book, self._reception, self._prospects)
        desk.open(self._rooms)
        self._module.serve(ShowPlan, self._show_plan)

    async def load(self) -> None:
        """Read what is kept; before anybody asks."""
        await self._world.load()
        await self._reception.load()
        await self._book.load()

    async def run(self) -> None:
        """Serve requests until cancelled: first what was left over, then what comes."""
        await self._module.clock.wait_ready(CLOCK_WAIT)
        executor = await self._executor()
        self._monitors = monitors = office_monitors(
            self._module, self._book, executor, self._conversation, self._options.patience
        )

        def changed() -> None:
            executor.reconsider()
            monitors.update()

        def world_changed() -> None:
            changed()
            self._book.changed.set()

        self._book.on_change, self._world.on_change = changed, world_changed
        self._module.start(monitors.run(), name="rogue.monitors")
        self._module.start(self._watch_deadlines(), name="rogue.deadlines")
        self._module.start(self._prospects.watch(), name="rogue.prospects")
        await executor.resume()
        while True:
            if not self._book.open_requests():
                await self._conversation.tell(trace.LISTENING)
            await self._work()
            await self._serve(executor)

    async def _work(self) -> None:
        """Wait until a request can be served: a new one, or one whose time has come again."""
        while True:
            self._book.changed.clear()
            if self._servable():
                return
            due = self._due(self._world.next_due(self._book.open_requests()))
            await self._first(due, self._book.changed.wait())

    def _servable(self) -> list[DeliveryRequest]:
        return servable(
            self._book.open_requests(),
            waits=self._world.waits,
            tray=self._world.facts.tray,
            places=self._options.tray,
        )

    def _now(self) -> float:
        """The time of the module's clock, which changes when it joins the bus."""
        return self._module.clock.now()

    async def _due(self, when: float | None) -> None:
        if when is None:
            await asyncio.get_running_loop().create_future()
        else:
            await self._module.clock.sleep_until(when)

    async def _first(self, *waits: Coroutine[object, object, object]) -> None:
        """Wait for the first of these."""
        tasks = [asyncio.create_task(wait, name="rogue.wait") for wait in waits]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            for task in done:
                task.result()
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)

    async def _serve(self, executor: Executor) -> None:
        self._locations = await self._rooms(self._options.endurance.absence)
        self._episode = Episode(
            rules=self._options.rules,
            locations=self._locations,
            directory=self._directory,
            distances=self._distances,
            agenda=self._agenda,
            store=self._store,
            book=self._book,
            executor=executor,
            conversation=self._conversation,
            decisions=DecisionRecorder(self._store, self._module.clock),
            servable=self._servable,
            told=self._told,
            level=self._options.level,
        )
        self._planning = True
        try:
            await self._episode.run()
        finally:
            self._planning = False
            self._told &= {request.id for request in self._book.open_requests()}

    async def _executor(self) -> Executor:
        tell = self._conversation.tell_step
        runner = StepRunner(self._robot, self._store, await self._store.identity(), tell)
        return Executor(
            module=self._module,
            store=self._store,
            book=self._book,
            world=self._world,
            directory=self._directory,
            runner=runner,
            patience=self._options.patience,
            arrival=self._options.verification,
        )

    async def _watch_deadlines(self) -> None:
        """Drop requests at their deadlines (Haigh & Veloso 1997, node 8)."""
        while True:
            self._book.deadlines_changed.clear()
            await self._drop_overdue()
            deadline = self._book.next_deadline()
            if deadline is None:
                await self._book.deadlines_changed.wait()
                continue
            # In lockstep the robot drives on only when what is overdue was dropped.
            async with contextlib.AsyncExitStack() as still:
                coming = still.enter_async_context(self._module.clock.at(deadline))
                await self._first(coming, self._book.deadlines_changed.wait())
                await self._drop_overdue()

    async def _drop_overdue(self) -> None:
        now = self._module.clock.now()
        for request in self._book.open_requests():
            if request.closing is None and request.deadline <= now:
                reason = f"its deadline, {show_time(request.deadline)}, passed before it was done"
                if (hold := self._world.waits(request)) is not None:
                    reason += f": {hold.reason}"
                await self._book.give_up(request.id, RequestState.FAILED, reason)

    async def _rooms(self, patience: float = 5.0) -> dict[str, tuple[float, float]]:
        """The rooms of the map, which does not change while the agent runs."""
        if not self._locations:
            self._locations = await self._robot.rooms(patience=patience)
        return dict(self._locations)

    async def _learn(self, rooms: Iterable[str]) -> None:
        await self._distances.learn(rooms, await self._rooms())

    async def _show_plan(self, message: ShowPlan, context: Context) -> PlanView:
        del message, context
        if self._episode is None:
            return PlanView(planning=False, nodes=[], executed=[], monitors=self._watching())
        return self._episode.view(planning=self._planning, monitors=self._watching())

    def _watching(self) -> list[MonitorView]:
        on = self._monitors.on() if self._monitors is not None else {}
        return [MonitorView(watches=str(m), requests=list(ids)) for m, ids in on.items()]


def _complain(error: MetricError) -> None:
    log.error("%s; the sum of ranks is used in its place", error)


async def run_agent(options: AgentOptions, bus: BusOptions) -> None:
    """Run the rogue module until cancelled; SIGHUP has it read the people directory again.

    Raises:
        TcaError: no router, another agent on the realm, no navigator within a bounded time, or
            the store or the people directory cannot be used.
    """
    directory = load_directory(options.directory)
    module = Module("rogue", options=bus, sole=True)
    async with Store(options.folder) as store:
        agent = Agent(module, store, directory, options)
        await agent.load()
        agent.open_desk()
        async with module:
            module.start(agent.run(), name="rogue.agent")
            with reread_on_hangup(directory, options.directory):
                await module.serve_forever()
