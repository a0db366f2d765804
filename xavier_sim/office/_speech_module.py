"""The ``speech`` module: the speech board and the keyboard, with people or without."""

from __future__ import annotations

import asyncio
import logging
from typing import Protocol

from tca_bus import (
    BusGoneError,
    BusOptions,
    Clock,
    Context,
    Module,
    NoHandlerError,
    PeerLostError,
    TaskContext,
    TaskError,
    TimedOutError,
)
from xavier_sim.messages import (
    Ask,
    Heard,
    ItemAction,
    ItemMoved,
    MoveItem,
    MovePerson,
    Occupant,
    Say,
    Spoken,
    TrueLocation,
    Typed,
    WhereReally,
    WhoIsIn,
    WorldDoors,
)
from xavier_sim.office._keyboard import Keyboard
from xavier_sim.office._people import ERRAND, Habits, People, truthful_answer
from xavier_sim.office._spoken_record import Done, Record, RecordFile
from xavier_sim.office._things import NotMovedError, item_action

MODULE = "speech"

CLOCK_WAIT = 60.0
"""Wall seconds to wait for simulated time to be known."""

TRUTH_TRIES = 12
TRUTH_PAUSE = 0.5
"""How often, and after how many wall seconds, the robot is looked for again when it is away."""

log = logging.getLogger(__name__)


class Audience(Protocol):
    """Whoever hears the robot and types on its keyboard."""

    def hear(self, text: str) -> None:
        """A sentence was said."""

    async def answer(self, ask: Ask, number: int) -> str:
        """Answer a question that is asked for the ``number``-th time.

        Raises:
            TaskError: ``no_answer``, when nobody answered in time.
        """


def no_answer(ask: Ask, why: str) -> TaskError:
    """The failure of a question that nobody answered."""
    data = {"question": ask.question, "timeout": ask.timeout}
    return TaskError("no_answer", f"nobody answered {ask.question!r}: {why}", data=data)


class SimulatedPeople:
    """People who answer after a while, truthfully, and some of them not at all.

    They also come and go, and take or bring things, when they are told to.
    """

    def __init__(self, speech: SpeechModule, *, seed: int, habits: Habits) -> None:
        self._speech, self._module = speech, speech.module
        self._record = speech.record
        self._people = People(seed=seed, habits=habits, sent=self._record.sent)
        self._module.serve(WhoIsIn, self._on_who_is_in)
        self._module.serve(MovePerson, self._on_move_person)

    def hear(self, text: str) -> None:
        """People hear what is said."""
        log.info("the robot says: %s", text)

    async def answer(self, ask: Ask, number: int) -> str:
        """Wait as long as a person takes, look where the robot is, and answer."""
        clock = self._module.clock
        delay = self._people.react(ask.question, number).delay
        asked_at = await self._see_robot(ask)
        heard = self._people.is_heard(ask, asked_at, clock.now())
        if not heard or delay is None or delay >= ask.timeout:
            await clock.sleep(ask.timeout)
            raise no_answer(ask, f"silence for {ask.timeout:g} s")
        await clock.sleep(delay)
        if ask.about in ERRAND:
            return self._people.room_for(ask, await self._rooms())
        really = await self._see_robot(ask)
        return truthful_answer(ask, really, is_there=self._is_there(ask, really))

    def _is_there(self, ask: Ask, really: TrueLocation) -> bool:
        """Whether the item can be had, for one who is asked for it in the right room."""
        if not (ask.user and ask.item) or really.room != ask.room:
            return True
        match ask.about:
            case "taking":
                return self._record.things.is_there(ask)
            case "placing":
                is_here = self._people.has_item(ask.room or "", ask.user, ask.item)
                return self._record.things.is_there(ask) and is_here
            case _:
                return True

    async def _rooms(self) -> list[str]:
        doors = await self._module.query(WorldDoors(), timeout=5.0)
        return list(dict.fromkeys(door.room for door in doors))

    async def _on_who_is_in(self, query: WhoIsIn, _context: Context) -> Occupant:
        return await self._occupant(query.room)

    async def _on_move_person(self, query: MovePerson, _context: Context) -> Occupant:
        self._people.send(query.room, present=query.present)
        await self._speech.save()
        return await self._occupant(query.room)

    async def _occupant(self, room: str) -> Occupant:
        await self._module.clock.wait_ready(CLOCK_WAIT)
        return self._people.occupant(room, self._module.clock.now())

    async def _see_robot(self, ask: Ask) -> TrueLocation:
        """Where the robot really is; it may be away for a moment, when it is being restarted."""
        for _ in range(TRUTH_TRIES):
            try:
                return await self._module.query(WhereReally(), timeout=5.0)
            except (NoHandlerError, PeerLostError, TimedOutError, BusGoneError) as error:
                log.warning("nobody sees the robot: %s", error)
                await asyncio.sleep(TRUTH_PAUSE)
        raise no_answer(ask, "the robot is not to be seen")


class Typist:
    """A person at the terminal of this process."""

    def __init__(self, module: Module, keyboard: Keyboard) -> None:
        self._module, self._keyboard = module, keyboard

    def hear(self, text: str) -> None:
        """Print what the robot says."""
        self._keyboard.show(f"Xavier says: {text}\n")

    async def answer(self, ask: Ask, number: int) -> str:
        """Ask on the terminal.

        The wait is passive: in lockstep simulated time stands still while a person thinks.
        """
        del number
        deadline = self._module.clock.now() + ask.timeout
        try:
            async with asyncio.timeout(None) as limit, asyncio.TaskGroup() as group:
                alarm = group.create_task(self._ring(deadline, limit), name="keyboard deadline")
                answer = await self._keyboard.ask(ask.question, ask.choices)
                alarm.cancel()
        except TimeoutError as error:
            self._keyboard.show("\n")
            raise no_answer(ask, f"silence for {ask.timeout:g} s") from error
        if answer is None:
            raise no_answer(ask, "the keyboard is gone, its input has ended")
        return answer

    async def _ring(self, deadline: float, limit: asyncio.Timeout) -> None:
        await self._module.clock.watch_until(deadline)
        limit.reschedule(asyncio.get_running_loop().time())


class SpeechModule:
    """Serves `Say` and `Ask`, each task once, also when it is sent again after a restart."""

    def __init__(self, options: BusOptions, file: RecordFile) -> None:
        self.module = Module(MODULE, options=options, sole=True)
        self._file = file
        self._writing = asyncio.Lock()
        self._audience: Audience | None = None
        self.module.serve(Say, self._on_say)
        self.module.serve(Ask, self._on_ask)
        self.module.serve(MoveItem, self._on_move_item)

    @property
    def record(self) -> Record:
        """What is kept: what was said and answered, and where people and things are."""
        return self._file.record

    async def save(self) -> None:
        """Keep the record."""
        async with self._writing:
            await asyncio.to_thread(self._file.save)

    async def run(self, audience: Audience) -> None:
        """Serve until cancelled.

        Raises:
            BusGoneError: there is no router.
            RefusedError: there is a speech board on the realm.
        """
        self._audience = audience
        async with self.module:
            await self.module.serve_forever()

    async def _on_say(self, say: Say, context: TaskContext) -> Spoken:
        done = self.record.done.get(context.id)
        if done is not None:
            return Spoken(text=done.text, time=done.time)
        clock = await self._clock()
        assert self._audience is not None
        self._audience.hear(say.text)
        done = await self._finish(context.id, say.text, clock.now())
        await self.module.broadcast(Heard(text=done.text, time=done.time))
        return Spoken(text=done.text, time=done.time)

    async def _on_ask(self, ask: Ask, context: TaskContext) -> Typed:
        done = self.record.done.get(context.id)
        if done is not None:
            return Typed(answer=done.text, time=done.time)
        clock = await self._clock()
        assert self._audience is not None
        number = self.record.number(context.id, ask.question)
        await self.save()
        answer = await self._audience.answer(ask, number)
        action = item_action(ask, answer)
        if action is not None:
            self.record.things.handed_over(ask, action)
        done = await self._finish(context.id, answer, clock.now())
        if action is not None and ask.user and ask.item:
            await self._tell_moved(ask.user, ask.item, ask.room, action)
        return Typed(answer=done.text, time=done.time)

    async def _on_move_item(self, query: MoveItem, _context: Context) -> ItemMoved:
        await self._clock()
        # First, so that nothing is moved of which nobody is told.
        where = await self.module.query(WhereReally(), timeout=5.0)
        try:
            self.record.things.move(query.user, query.item, query.action)
        except NotMovedError as error:
            raise TaskError("not_there", str(error)) from error
        await self.save()
        return await self._tell_moved(query.user, query.item, where.room, query.action)

    async def _tell_moved(
        self, user: str, item: str, room: str | None, action: ItemAction
    ) -> ItemMoved:
        now = self.module.clock.now()
        moved = ItemMoved(user=user, item=item, room=room or "", action=action, time=now)
        await self.module.broadcast(moved)
        return moved

    async def _clock(self) -> Clock:
        await self.module.clock.wait_ready(CLOCK_WAIT)
        return self.module.clock

    async def _finish(self, task: str, text: str, when: float) -> Done:
        """Keep an outcome before anybody hears of it: an item is moved once, whatever happens."""
        done = Done(text=text, time=when)
        self.record.finish(task, done)
        await self.save()
        return done
