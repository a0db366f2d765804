"""The ``speech`` module: the speech board and the keyboard, with people or without."""

from __future__ import annotations

import asyncio
import logging
from typing import Literal, Protocol, cast

from tca_bus import (
    BusGoneError,
    BusOptions,
    Clock,
    Module,
    NoHandlerError,
    PeerLostError,
    TaskContext,
    TaskError,
    TimedOutError,
)
from xavier_sim.keyboard import Keyboard
from xavier_sim.messages import (
    Ask,
    Heard,
    ItemMoved,
    Say,
    Spoken,
    TrueLocation,
    Typed,
    WhereReally,
)
from xavier_sim.people import People, item_action, truthful_answer
from xavier_sim.spoken_record import Done, RecordFile

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
    """People who answer after a while, truthfully, and sometimes not at all."""

    def __init__(self, module: Module, people: People) -> None:
        self._module, self._people = module, people

    def hear(self, text: str) -> None:
        """People hear what is said."""
        log.info("the robot says: %s", text)

    async def answer(self, ask: Ask, number: int) -> str:
        """Wait as long as a person takes, look where the robot is, and answer."""
        clock = self._module.clock
        delay = self._people.react(ask.question, number).delay
        if delay is None or delay >= ask.timeout:
            await clock.sleep(ask.timeout)
            raise no_answer(ask, f"silence for {ask.timeout:g} s")
        await clock.sleep(delay)
        return truthful_answer(ask, await self._see_robot(ask))

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

    def __init__(self, options: BusOptions, record: RecordFile) -> None:
        self.module = Module(MODULE, options=options, sole=True)
        self._record = record
        self._writing = asyncio.Lock()
        self._audience: Audience | None = None
        self.module.serve(Say, self._on_say)
        self.module.serve(Ask, self._on_ask)

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
        done = self._record.record.done.get(context.id)
        if done is not None:
            return Spoken(text=done.text, time=done.time)
        clock = await self._clock()
        assert self._audience is not None
        self._audience.hear(say.text)
        done = await self._finish(context.id, say.text, clock.now())
        await self.module.broadcast(Heard(text=done.text, time=done.time))
        return Spoken(text=done.text, time=done.time)

    async def _on_ask(self, ask: Ask, context: TaskContext) -> Typed:
        done = self._record.record.done.get(context.id)
        if done is not None:
            return Typed(answer=done.text, time=done.time)
        clock = await self._clock()
        assert self._audience is not None
        number = self._record.record.number(context.id, ask.question)
        await self._save()
        answer = await self._audience.answer(ask, number)
        done = await self._finish(context.id, answer, clock.now())
        await self._move_item(ask, done)
        return Typed(answer=done.text, time=done.time)

    async def _move_item(self, ask: Ask, done: Done) -> None:
        action = item_action(ask, done.text)
        if action is None or not (ask.user and ask.item):
            return
        moved = ItemMoved(
            user=ask.user,
            item=ask.item,
            room=ask.room or "",
            action=cast("Literal['placed', 'taken']", action),
            time=done.time,
        )
        await self.module.broadcast(moved)

    async def _clock(self) -> Clock:
        await self.module.clock.wait_ready(CLOCK_WAIT)
        return self.module.clock

    async def _finish(self, task: str, text: str, when: float) -> Done:
        """Keep an outcome before anybody hears of it: an item is moved once, whatever happens."""
        done = Done(text=text, time=when)
        self._record.record.finish(task, done)
        await self._save()
        return done

    async def _save(self) -> None:
        async with self._writing:
            await asyncio.to_thread(self._record.save)
