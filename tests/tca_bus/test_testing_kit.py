"""The testing kit for those who write modules."""

from __future__ import annotations

import pytest

from tca_bus import (
    Broadcast,
    Command,
    HandlerFailedError,
    Inform,
    InvalidMessageError,
    Module,
    Query,
    TaskError,
    TaskFailedError,
)
from tca_bus.testing import ScriptedModule, bus, central, eventually

pytestmark = pytest.mark.bus


class Ask(Query[int]):
    number: int = 0


class Do(Command[str]):
    pass


class Tell(Inform):
    number: int


class Shout(Broadcast):
    number: int


async def test_lines_are_followed_once_each_and_the_last_stays():
    async with bus() as options, ScriptedModule("robot", options=options) as robot:
        robot.answers(Ask, 1, 2).fails(Ask, TaskError("tired", "enough"))
        asker = robot.module
        assert [await asker.query(Ask(number=n)) for n in range(2)] == [1, 2]
        for _ in range(2):
            with pytest.raises(HandlerFailedError, match="enough"):
                await asker.query(Ask())
        robot.computes(Ask, double)
        assert await asker.query(Ask(number=21)) == 42
        assert [message.number for message in robot.received(Ask)] == [0, 1, 0, 0, 21]


async def double(message):
    return 2 * message.number


async def test_an_answer_of_another_type_is_refused_in_the_script():
    async with bus() as options:
        robot = ScriptedModule("robot", options=options)
        with pytest.raises(InvalidMessageError, match=r"ask\.reply.*'many'"):
            robot.answers(Ask, "many")
        with pytest.raises(InvalidMessageError, match=r"ask\.reply"):
            robot.holds(Ask).release("many")


async def test_one_way_messages_are_remembered_with_their_sender():
    async with (
        bus() as options,
        ScriptedModule("robot", options=options) as robot,
        Module("me", options=options) as me,
    ):
        robot.hears(Tell, Shout)
        await me.wait_for(Tell, timeout=10.0)
        await me.inform(Tell(number=1))
        await me.inform(Tell(number=2))
        assert await robot.receives(Tell, 2) == [Tell(number=1), Tell(number=2)]
        assert [call.sender for call in robot.calls(Tell)] == ["me", "me"]
        with pytest.raises(AssertionError, match="2 of 3 'tell' came within"):
            await robot.receives(Tell, 3, timeout=0.1)


async def test_what_is_held_waits_until_it_is_let_go():
    async with (
        bus() as options,
        central(options),
        ScriptedModule("robot", options=options) as robot,
        Module("me", options=options) as me,
    ):
        hold = robot.holds(Do)
        with pytest.raises(AssertionError, match="no message came"):
            await hold.reached(timeout=0.05)
        await me.wait_for(Do, "tca.submit", timeout=10.0)
        task = await me.execute(Do())
        await hold.reached()
        hold.fail(TaskError("blocked", "the door is shut"))
        with pytest.raises(TaskFailedError, match="the door is shut"):
            await task.result(timeout=10.0)
        with pytest.raises(AssertionError, match="let go before"):
            hold.release("done")


async def test_one_that_vanishes_is_missed():
    async with (
        bus() as options,
        Module("me", options=options) as me,
        ScriptedModule("robot", options=options) as robot,
    ):
        await eventually(lambda: "robot" in me.available())
        await robot.vanish()
        await eventually(lambda: "robot" not in me.available())
