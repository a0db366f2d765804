"""The ``xavier`` module: the simulated world on the bus."""

from __future__ import annotations

import asyncio
import logging
import time

from tca_bus import (
    AwaitTime,
    BusOptions,
    Context,
    Module,
    Settle,
    Settled,
    SimulatedTime,
)
from xavier_sim.messages import Drive
from xavier_sim.running._driver import STOP, Driver
from xavier_sim.running._offenders import Offenders
from xavier_sim.running._outlet import Outlet, Witness
from xavier_sim.running._pacing import (
    ALONE_PAUSE,
    ANSWER_PATIENCE,
    IDLE_REPEAT,
    Metronome,
)
from xavier_sim.running._plant import Plant
from xavier_sim.running._quiet import Quiet
from xavier_sim.running._reflex import Reflex
from xavier_sim.running._simulated_time import HOLD_LIMIT, Demands, TimeNews
from xavier_sim.running._standstill import Standstill
from xavier_sim.snapshots import Saved, SnapshotFile

log = logging.getLogger(__name__)

MODULE = "xavier"

SAVE_AFTER = 1.0
"""Wall seconds after which a world that stands still is saved as it is."""


class RobotModule:
    """Shows a robot to the bus: sensors and time out, driving commands and doors in.

    Args:
        state: the world and its time, or what stands for it.
        store: where to keep it, None for nowhere.
        options: how to join the bus; the module's own clock is wall time.
        witness: who records what happens.
    """

    def __init__(
        self,
        state: Plant,
        store: SnapshotFile | None,
        options: BusOptions,
        witness: Witness | None = None,
    ) -> None:
        self._state, self._store, self._witness = state, store, witness
        wall = options.model_copy(update={"clock": "wall", "ordered": True})
        self._module = Module(MODULE, options=wall, sole=True)
        self._driver, self._demands, self._news = Driver(), Demands(), TimeNews()
        self._quiet, self._was_busy, self._has_news = Quiet(), False, False
        self._standstill, self._offenders = Standstill(options.realm), Offenders()
        self._present: dict[str, str] = {}
        self._bell, self._reflex = asyncio.Event(), Reflex()
        state.attach(self._reflex)
        state.wake_by(self._bell.set)
        self._changed = True
        self._saved_at = float("-inf")
        self._writing: asyncio.Future[None] | None = None
        self._sensors_sent = float("-inf")
        self._outlet = Outlet(self._module, witness, lambda: state.now, self._before_news)
        self._desk = state.open_desk(self._module, self._outlet, self._change)
        self._module.serve(Drive, self._on_drive)
        self._module.serve(AwaitTime, self._on_await_time)
        self._module.serve(Settled, self._on_settled)

    async def run(self) -> None:
        """Run until cancelled, or until a recording is over; then keep the world.

        Raises:
            BusGoneError: there was no router to begin with.
            RefusedError: there is a robot on the realm.
            StandstillError: what a recording waits for has not come.
        """
        has_begun = False
        try:
            async with self._module:
                has_begun = True
                self._module.start(self._watch_presence(), name="xavier presence")
                await self._show_witness()
                if self._state.speed is None:
                    await self._run_lockstep()
                else:
                    await self._run_paced(self._state.speed)
        finally:
            # Only now nobody can change the world any more.
            if has_begun:
                await self._save(stopped=True)

    async def _run_paced(self, speed: float) -> None:
        metronome = Metronome(speed, time.monotonic())
        await self._send_sensors()
        while not self._state.is_over:
            await asyncio.sleep(metronome.pause(time.monotonic()))
            await self._tick(*self._driver.command(self._state.tick))
            await self._desk.tell_news()
            await self._send_sensors()
            await self._tell_time()

    async def _run_lockstep(self) -> None:
        while True:
            await self._send_sensors()
            if self._state.must_save:
                # While the driver thinks: a tick that it has answered need not wait for the disk.
                await self._save()
            await self._until_may_tick()
            self._say_it_goes_on()
            if self._state.is_over:
                return
            driven = self._driven
            await self._tick(*(self._driver.command(self._state.tick) if driven else STOP))
            await asyncio.sleep(0 if driven else ALONE_PAUSE)

    async def _until_may_tick(self) -> None:
        """Stand still until time may move; say meanwhile what might have been lost.

        The time and the news of a tick are told once the driver has answered that tick, so that
        whoever is woken by them finds the driver in the same state in every run.
        """
        while True:
            self._bell.clear()
            wall = time.monotonic()
            self._clean_demands(wall)
            self._say_what_is_awaited(wall)
            may_tick = self._may_tick()
            if self._settled:
                await self._tell_time(resting=self._state.is_over or not may_tick)
                await self._tell_news()
                if self._may_tick() and await self._is_quiet(wall):
                    return
            await self._repeat_sensors(wall)
            await self._save_if_old(wall)
            await self._wait_for_bell()

    def _may_tick(self) -> bool:
        tick = self._state.tick
        return self._state.may_tick(
            driven=self._driven,
            answered=self._driver.answered(tick),
            busy=self._driver.busy(tick),
            moving=self._demands.moving,
            holding=self._demands.holding,
        )

    async def _tell_news(self) -> None:
        """Tell what came about in this tick, once."""
        if self._has_news:
            self._has_news = False
            await self._desk.tell_news()

    async def _is_quiet(self, wall: float) -> bool:
        """Whether everybody has taken what was told; asks those of whom it is not known."""
        number = self._quiet.question(wall, self._present.__contains__)
        if number is not None:
            await self._module.broadcast(Settle(number=number))
        for module in self._quiet.give_up(wall):
            log.warning("module %s does not answer; simulated time goes on without it", module)
        return self._quiet.is_quiet

    def _clean_demands(self, wall: float) -> None:
        for module in self._demands.clean(wall, self._present.__contains__):
            log.warning(
                "simulated time stood still for module %s for %g s; it goes on without it",
                module,
                HOLD_LIMIT,
            )

    def _say_what_is_awaited(self, wall: float) -> None:
        tick, driven = self._state.tick, self._driven
        if driven and not self._driver.answered(tick):
            # Who drives may be held by a person with a debugger: for that there is no limit.
            word = self._standstill.look(tick, f"module {self._driver.name} to answer", wall)
        else:
            what = self._state.awaited(driven=driven, busy=self._driver.busy(tick))
            word = self._standstill.look(tick, what, wall, self._state.patience)
        if word is not None:
            log.warning("%s", word)

    def _say_it_goes_on(self) -> None:
        word = self._standstill.end(self._state.tick, time.monotonic())
        if word is not None:
            log.info("%s", word)

    @property
    def _driven(self) -> bool:
        return self._driver.name in self._present.values()

    @property
    def _settled(self) -> bool:
        """Whether the driver, if there is one, has answered this tick."""
        return not self._driven or self._driver.answered(self._state.tick)

    async def _wait_for_bell(self) -> None:
        """Wait for a message, or a short while: waking modules and lost answers are timed."""
        patience = ANSWER_PATIENCE / 3
        if self._settled:
            news_in = self._news.due_in(self._state.now, time.monotonic())
            patience = min(patience, max(news_in, 0.001))
        try:
            async with asyncio.timeout(patience):
                await self._bell.wait()
        except TimeoutError:
            return

    async def _repeat_sensors(self, wall: float) -> None:
        unanswered = self._driven and not self._driver.answered(self._state.tick)
        if wall - self._sensors_sent > (ANSWER_PATIENCE if unanswered else IDLE_REPEAT):
            await self._send_sensors()

    async def _tick(self, speed: float, turn_rate: float) -> None:
        if self._state.must_save:
            await self._save()
        speed, turn_rate = self._restrained(speed, turn_rate)
        self._note_command(speed, turn_rate)
        await self._state.advance(speed, turn_rate)
        self._changed = True
        await self._show_witness()
        if self._demands.reached(self._state.now, time.monotonic()):
            self._news.hurry()
        self._has_news = True

    def _restrained(self, speed: float, turn_rate: float) -> tuple[float, float]:
        """The command as the reflex lets it go to the wheels."""
        held = self._reflex.holds
        allowed = self._reflex.allow(speed, turn_rate)
        if self._reflex.holds and not held:
            log.info("stopped by reflex at tick %d", self._state.tick)
        return allowed

    def _note_command(self, speed: float, turn_rate: float) -> None:
        if self._witness is None:
            return
        tick = self._state.tick
        busy = self._driver.busy(tick)
        self._outlet.note(Drive(tick=tick, speed=speed, turn_rate=turn_rate, busy=busy))

    async def _show_witness(self) -> None:
        if self._witness is not None:
            state = self._state
            await self._witness.sense(state.sensors(), state.true_location(), state.standing())

    async def _send_sensors(self) -> None:
        self._sensors_sent = time.monotonic()
        await self._module.broadcast(self._state.sensors())

    async def _before_news(self) -> None:
        """Let all know what time it is before they hear of something that they may act upon."""
        if self._state.speed is None:
            self._quiet.stir()
            await self._tell_time(resting=True)

    async def _tell_time(self, *, resting: bool = False) -> None:
        now, wall = self._state.now, time.monotonic()
        if self._news.due_in(now, wall, resting=resting) > 0.0:
            return
        self._news.told(now, wall)
        await self._module.broadcast(SimulatedTime(time=now, speed=self._state.speed))

    async def _save_if_old(self, wall: float) -> None:
        if self._changed and wall - self._saved_at > SAVE_AFTER:
            await self._save()

    async def _save(self, *, stopped: bool = False) -> None:
        saved = self._state.saved(stopped=stopped)
        self._saved_at, self._changed = time.monotonic(), False
        if saved is None:
            return
        if self._store is not None:
            await self._write(self._store, saved)
        self._state.tick_limit = saved.tick_limit

    async def _write(self, store: SnapshotFile, saved: Saved) -> None:
        """Write a snapshot after the one before, which goes on though nobody awaits it any more."""
        if self._writing is not None:
            await asyncio.wait([self._writing])
        loop = asyncio.get_running_loop()
        self._writing = loop.run_in_executor(None, store.save, saved)
        await asyncio.shield(self._writing)

    async def _watch_presence(self) -> None:
        async with self._module.watch_modules() as changes:
            async for change in changes:
                module = change.module
                if change.appeared:
                    self._present[module.incarnation] = module.name
                else:
                    self._present.pop(module.incarnation, None)
                    self._offenders.forget(module.name)
                if module.name == self._driver.name:
                    self._driver.forget()
                    self._sensors_sent = float("-inf")
                self._bell.set()

    async def _on_drive(self, drive: Drive, context: Context) -> None:
        tick = self._state.tick
        if drive.busy != self._was_busy:
            self._was_busy = drive.busy
            self._quiet.stir()
        if self._driver.hear(drive, context.sender, tick):
            self._offenders.clear(context.sender)
            self._bell.set()
        elif self._offenders.offend(context.sender, time.monotonic()):
            log.warning("command of %s for tick %d ignored at %d", context.sender, drive.tick, tick)

    async def _on_await_time(self, demand: AwaitTime, _context: Context) -> None:
        now, wall = self._state.now, time.monotonic()
        self._quiet.hear(demand)
        if self._demands.note(demand, now, wall):
            self._news.hurry()
        self._bell.set()

    async def _on_settled(self, answer: Settled, _context: Context) -> None:
        self._quiet.take(answer)
        self._bell.set()

    def _change(self) -> None:
        """Keep a world that was changed by a command soon, and look whether time may move."""
        self._changed, self._saved_at = True, float("-inf")
        self._bell.set()
