"""The speech board and the keyboard on a real bus, with central and the simulated robot."""

from __future__ import annotations

import asyncio
import io
import json
import os
from contextlib import asynccontextmanager

import pytest

from tca_bus import HandlerFailedError, Module, TaskFailedError
from tca_bus.testing import bus, central, eventually
from xavier_sim.floors import load_floor
from xavier_sim.messages import Ask, Heard, ItemMoved, MoveItem, MovePerson, Say, WhoIsIn
from xavier_sim.office import Habits, Keyboard, RecordFile, SimulatedPeople, SpeechModule, Typist
from xavier_sim.office._people import QUICKEST, SLOWEST
from xavier_sim.running import RobotModule, RobotState, SimClock
from xavier_sim.world import World

pytestmark = pytest.mark.bus

PLAN = load_floor()
ROOM = "r-5303"


@asynccontextmanager
async def running(coroutine, name):
    async with asyncio.TaskGroup() as group:
        task = group.create_task(coroutine, name=name)
        try:
            yield
        finally:
            task.cancel()


def auto_speech(options, folder=None, **habits):
    speech = SpeechModule(options, RecordFile(folder))
    return speech.run(SimulatedPeople(speech, seed=1, habits=Habits(**habits)))


def typed_speech(options, source, screen):
    async def run():
        speech = SpeechModule(options, RecordFile(None))
        async with Keyboard(source, screen) as keyboard:
            await speech.run(Typist(speech.module, keyboard))

    return run()


@asynccontextmanager
async def office(*, room=ROOM):
    """A bus with central and a robot that stands in a room, and one who asks."""
    world = World(PLAN, seed=1)
    world.place_robot(PLAN.places[room].x, PLAN.places[room].y, 0.0)
    state = RobotState(world, SimClock(1000.0), speed=None)
    async with bus(clock="sim") as options, central(options):
        robot = RobotModule(state, None, options).run()
        async with running(robot, "robot"), Module("asker", options=options) as asker:
            await asker.clock.wait_ready(10)
            yield asker


def ask(about="place", choices=("y", "n"), room=ROOM, **more):
    return Ask(question="Am I here?", about=about, choices=choices, room=room, **more)


def hand_over(about):
    return ask(about, ("y", "i"), user="mitchell", item="delivermail")


async def answer(asker, question, **more):
    handle = await asker.execute(question, wait_for_handler=10.0, **more)
    return await handle.result(timeout=20.0)


async def test_saying_is_heard():
    async with (
        office() as asker,
        running(auto_speech(asker.options), "speech"),
        asker.subscribe(Heard) as heard,
    ):
        spoken = await answer(asker, Say(text="Good morning."))
        assert spoken.text == "Good morning."
        assert (await heard.get()).text == "Good morning."


async def test_people_answer_truthfully_after_a_while():
    async with office() as asker, running(auto_speech(asker.options), "speech"):
        begun = asker.clock.now()
        typed = await answer(asker, ask())
        assert typed.answer == "y"
        assert QUICKEST - 0.2 <= typed.time - begun <= SLOWEST + 0.2
        assert (await answer(asker, ask(room="r-5305"))).answer == "n"
        assert (await answer(asker, ask("where", (), None))).answer == ROOM


async def test_silence_times_out():
    async with office() as asker, running(auto_speech(asker.options, silence=1.0), "speech"):
        begun = asker.clock.now()
        with pytest.raises(TaskFailedError) as caught:
            await answer(asker, ask(timeout=12.0))
        assert caught.value.failure.name == "no_answer"
        assert asker.clock.now() - begun >= 11.9


async def test_item_is_placed_once_even_when_asked_again_after_a_restart(tmp_path):
    async with office() as asker, asker.subscribe(ItemMoved) as moved:
        async with running(auto_speech(asker.options, tmp_path), "speech"):
            first = await answer(asker, hand_over("placing"), id="hand-over-1")
            assert first.answer == "y"
            assert (await moved.get()).action == "placed"
        record = json.loads((tmp_path / "speech.json").read_text())
        assert record["done"]["hand-over-1"]["text"] == "y"
        again = RecordFile(tmp_path)
        speech = SpeechModule(asker.options, again)
        context = type("Again", (), {"id": "hand-over-1"})()
        typed = await speech._on_ask(hand_over("placing"), context)
        assert typed == first
        assert moved.waiting == 0


async def test_people_go_and_things_go_another_way(tmp_path):
    async with office() as asker, asker.subscribe(ItemMoved) as moved:
        async with running(auto_speech(asker.options, tmp_path), "speech"):
            await asker.wait_for(MovePerson, MoveItem, timeout=10)
            assert (await answer(asker, hand_over("placing"))).answer == "y"
            await asker.query(MoveItem(user="mitchell", item="delivermail", action="taken"))
            assert not (await asker.query(MovePerson(room=ROOM, present=False))).present
        async with running(auto_speech(asker.options, tmp_path), "speech"):
            with pytest.raises(TaskFailedError) as caught:
                await answer(asker, hand_over("taking"))
            assert caught.value.failure.name == "no_answer"
            await asker.wait_for(WhoIsIn, MovePerson, MoveItem, timeout=10)
            assert not (await asker.query(WhoIsIn(room=ROOM))).present
            await asker.query(MovePerson(room=ROOM, present=True))
            assert (await answer(asker, hand_over("taking"))).answer == "i"
            with pytest.raises(HandlerFailedError, match="it is not on the tray") as refused:
                await asker.query(MoveItem(user="mitchell", item="delivermail", action="taken"))
            assert refused.value.failure.name == "not_there"
            assert [(await moved.get()).action for _ in range(2)] == ["placed", "taken"]


async def test_a_user_is_asked_wherever_the_robot_is():
    async with office() as asker, running(auto_speech(asker.options, away=1.0), "speech"):
        question = ask("pickup", (), None, user="mitchell", item="pickupbook")
        room = (await answer(asker, question)).answer
        assert room.startswith("r-5")
        assert (await answer(asker, question)).answer == room


async def test_speech_killed_while_people_think_answers_after_its_restart(tmp_path):
    async with office() as asker, asker.subscribe(ItemMoved) as moved:
        async with running(auto_speech(asker.options, tmp_path, silence=1.0), "speech"):
            handle = await asker.execute(hand_over("taking"), wait_for_handler=10.0)
            await eventually((tmp_path / "speech.json").exists)
        async with running(auto_speech(asker.options, tmp_path), "speech"):
            assert (await handle.result(timeout=20.0)).answer == "y"
            assert (await moved.get()).action == "taken"
            assert moved.waiting == 0


@pytest.fixture
def terminal():
    """Lines to be typed, what is written to type them, and a screen."""
    reading, writing = os.pipe()
    with os.fdopen(reading) as source, os.fdopen(writing, "w") as keys:
        yield source, keys, io.StringIO()
        keys.close()


async def test_keyboard_asks_and_takes_the_answer(terminal):
    source, keys, screen = terminal
    async with (
        office() as asker,
        running(typed_speech(asker.options, source, screen), "speech"),
    ):
        await answer(asker, Say(text="Please answer on my keyboard."))
        handle = await asker.execute(ask(), wait_for_handler=10.0)
        await eventually(lambda: "Am I here? (y/n): " in screen.getvalue())
        keys.write("perhaps\ny\n")
        keys.flush()
        assert (await handle.result(timeout=20.0)).answer == "y"
    assert "Please answer on my keyboard." in screen.getvalue()
    assert "Please type y or n." in screen.getvalue()


async def test_keyboard_question_times_out_when_time_passes(terminal):
    source, _, screen = terminal
    async with (
        office() as asker,
        running(typed_speech(asker.options, source, screen), "speech"),
    ):
        handle = await asker.execute(ask(timeout=10.0), wait_for_handler=10.0)
        await eventually(lambda: "Am I here?" in screen.getvalue())
        await asker.clock.sleep(12.0)
        with pytest.raises(TaskFailedError) as caught:
            await handle.result(timeout=20.0)
        assert caught.value.failure.name == "no_answer"


class Broken(io.StringIO):
    """A terminal that hangs up."""

    def __next__(self):
        raise OSError(5, "Input/output error")


async def test_a_terminal_that_hangs_up_is_no_answer_and_told(caplog):
    async with Keyboard(Broken(), io.StringIO()) as keyboard:
        assert await keyboard.ask("Am I here?", ("y", "n")) is None
    assert "the keyboard cannot be read any more" in caplog.text


async def test_closed_terminal_is_no_answer():
    async with office() as asker:
        screen = io.StringIO()
        async with running(typed_speech(asker.options, io.StringIO(""), screen), "speech"):
            with pytest.raises(TaskFailedError) as caught:
                await answer(asker, ask())
            assert caught.value.failure.name == "no_answer"
            assert "input has ended" in caught.value.failure.text
