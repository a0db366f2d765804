"""The monitors on a real bus: what is heard there reaches the plans."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest
from rogue_fakes import ScriptedRobot, make_request

from rogue.conversation import Conversation
from rogue.execution import Executor, KnownWorld, Patience, StepRunner, as_published
from rogue.memory import Hold, Store
from rogue.monitors import office_monitors
from rogue.outcomes import Trouble
from rogue.requests import RequestBook, load_directory
from tca_bus import Module
from tca_bus.testing import ScriptedModule, bus, central, eventually
from xavier_sim.messages import Ask, DoorMoved, DoorState, ItemMoved, Typed, WorldDoors

pytestmark = pytest.mark.bus

MAIL = ("mitchell", "delivermail")


class Scene:
    """The planner's module with its monitors, and one that stands for robot and people."""

    def __init__(self, module: Module, world: ScriptedModule, store: Store) -> None:
        self.module, self.office = module, world
        directory, patience = load_directory(), Patience()
        self.book = RequestBook(module, store, directory)
        self.world = KnownWorld(store, module)
        said = Conversation(module, store)
        executor = Executor(
            module=module,
            store=store,
            book=self.book,
            world=self.world,
            directory=directory,
            runner=StepRunner(ScriptedRobot(), store, "cafe", said.tell_step),
            patience=patience,
            arrival=as_published(),
        )
        self.monitors = office_monitors(module, self.book, executor, said, patience)
        self.book.on_change = self.world.on_change = self.monitors.update


@asynccontextmanager
async def scene(folder: Path) -> AsyncIterator[Scene]:
    async with (
        bus() as options,
        central(options),
        ScriptedModule("xavier", options=options) as office,
        Module("rogue", options=options) as module,
        Store(folder) as store,
    ):
        at = Scene(module, office, store)
        office.answers(WorldDoors, [DoorState(room="r-5303", open=True)])
        office.answers(Ask, Typed(answer="y", time=1.0))
        await module.wait_for(WorldDoors, Ask, timeout=10.0)
        deadline = module.clock.now() + 3600.0
        await at.book.add(make_request(posted=module.clock.now(), deadline=deadline), None)
        running = asyncio.create_task(at.monitors.run())
        await eventually(lambda: office.calls(WorldDoors))
        yield at
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)


async def test_doors_items_and_answers_are_heard(tmp_path: Path) -> None:
    async with scene(tmp_path) as at:

        async def hears_of_door(*, is_open: bool) -> bool:
            await at.office.module.broadcast(DoorMoved(room="r-5303", open=is_open, time=1.0))
            return at.world.is_held("a") is not is_open

        # Again until it is heard: a subscription begins when it begins.
        await eventually(lambda: hears_of_door(is_open=False))
        await eventually(lambda: hears_of_door(is_open=True))
        until = at.module.clock.now() + 600.0
        await at.world.put_off([Hold("a", "r-5303", until, "nobody answered", Trouble.NOBODY)])

        async def sees_an_answer() -> bool:
            question = Ask(question="Are you there?", room="r-5303")
            await (await at.module.execute(question)).result()
            return not at.world.is_held("a")

        await eventually(sees_an_answer)

        async def hears_what_was_brought() -> bool:
            user, item = MAIL
            moved = ItemMoved(user=user, item=item, room="", action="brought", time=3.0)
            await at.office.module.broadcast(moved)
            return at.book.find("a") is None

        await eventually(hears_what_was_brought)
        await eventually(lambda: at.monitors.on() == {})
