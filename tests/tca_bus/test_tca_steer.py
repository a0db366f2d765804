"""``tca tap``, ``suspend``, ``resume``, ``retry`` and ``prioritize`` as their users have them."""

from __future__ import annotations

import asyncio
import json

import pytest
from central_robot import Arrive, Deliver, Drive, Quick, Where
from test_tca_cli import finish, office

from tca_bus import Constraint, RefusedError, TaskFailedError
from tca_bus._attachments import TapCondition
from tca_bus._protocol import FindTask
from tca_bus._tree_queries import ListAttachments
from tca_bus.testing import eventually

pytestmark = [pytest.mark.slow, pytest.mark.bus, pytest.mark.process]

FREE = Constraint.NONE


async def status_of(here, task):
    return await here.me.query(FindTask(id=getattr(task, "id", task)))


class Tapping:
    """``tca tap`` under way, with a person at its standard input."""

    def __init__(self, process):
        self.process = process

    async def line(self):
        """The next line of standard output."""
        async with asyncio.timeout(20.0):
            return (await self.process.stdout.readline()).decode().rstrip()

    async def asked(self):
        """Wait until it asks its question."""
        async with asyncio.timeout(20.0):
            while b"let it pass?" not in (line := await self.process.stderr.readline()):
                assert line, "it ended"

    async def says(self, answer):
        """What the person types, at the question."""
        await self.asked()
        self.process.stdin.write(f"{answer}\n".encode())
        await self.process.stdin.drain()

    async def leaves(self):
        """Standard input ends, at the question."""
        await self.asked()
        self.process.stdin.close()

    async def end(self):
        self.process.terminate()
        return (await finish(self.process)).code


async def tapping(here, condition, name, *more):
    """Start ``tca tap`` and wait until what it tapped is tapped."""
    pipe = asyncio.subprocess.PIPE
    process = await here.start("tap", condition, name, *more, stdin=pipe)
    own = f"tca-{process.pid}"

    async def is_in_force():
        listed = await here.me.query(ListAttachments())
        straight = all(sees_tap(module, own) for module in (here.me, here.robot))
        return straight or any(own in one.what.listener.name for one in listed)

    await eventually(is_in_force)
    return Tapping(process)


def sees_tap(module, by):
    return any(one.name == by and one.taps for one in module.modules())


async def test_a_tap_on_a_task_prints_what_comes():
    async with office() as here:
        tap = await tapping(here, "WhenAchieved", "quick", "--json")
        assert await (await here.me.execute(Quick(number=3), id="q1")).result(timeout=10.0) == 3
        told = json.loads(await tap.line())
        assert (told["condition"], told["message"], told["task"]) == ("WhenAchieved", "quick", "q1")
        assert (told["sender"], told["data"], told["reply"]) == ("me", {"number": 3}, 3)
        assert await tap.end() == 0


async def test_a_tap_on_a_question_prints_it_and_its_answer():
    async with office() as here:
        tap = await tapping(here, "AfterReplied", "where")
        assert await here.me.query(Where()) == "home"
        assert await tap.line() == "AfterReplied  where  from me  {}  -> home"
        assert await tap.end() == 0


async def test_a_person_lets_a_task_pass_or_not():
    async with office() as here:
        tap = await tapping(here, "BeforeHandling", "quick", "--ask")
        task = await here.me.execute(Quick(number=3))
        await tap.asked()
        assert "to be achieved" in (await status_of(here, task)).waiting_for
        tap.process.stdin.write(b"y\n")
        assert await task.result(timeout=10.0) == 3
        task = await here.me.execute(Quick(number=4))
        await tap.says("n")
        with pytest.raises(TaskFailedError, match="a person did not let it pass"):
            await task.result(timeout=10.0)
        task = await here.me.execute(Quick(number=5))
        await tap.leaves()
        with pytest.raises(TaskFailedError, match="nobody can let it pass"):
            await task.result(timeout=10.0)
        assert await tap.end() == 0


async def test_a_question_whose_task_is_killed_takes_no_answer_from_the_next():
    async with office() as here:
        tap = await tapping(here, "BeforeHandling", "quick", "--ask")
        first = await here.me.execute(Quick(number=3))
        await tap.asked()
        await first.kill("changed my mind")
        second = await here.me.execute(Quick(number=4))
        await tap.says("y")
        assert await second.result(timeout=10.0) == 4
        assert await tap.end() == 0


async def test_a_person_lets_a_question_pass_or_not():
    async with office() as here:
        tap = await tapping(here, "BeforeHandling", "where", "--ask")
        asking = asyncio.ensure_future(here.me.query(Where(), timeout=20.0))
        await tap.says("y")
        assert await asking == "home"
        asking = asyncio.ensure_future(here.me.query(Where(), timeout=20.0))
        await tap.says("no")
        with pytest.raises(RefusedError, match="a person did not let it pass"):
            await asking
        assert await tap.end() == 0


async def test_an_end_of_the_command_lets_go_what_it_holds():
    async with office() as here:
        tap = await tapping(here, "BeforeHandling", "quick", "--ask")
        task = await here.me.execute(Quick(number=3))
        await tap.asked()
        assert await tap.end() == 0
        assert await task.result(timeout=10.0) == 3


async def test_what_cannot_be_tapped_is_refused():
    async with office() as here:
        unknown, holds_not, straight, nobody = await asyncio.gather(
            here.tca("tap", "WhenDone", "quick"),
            here.tca("tap", "WhenSent", "quick", "--ask"),
            here.tca("tap", "WhenAchieved", "where"),
            here.tca("tap", "WhenSent", "wher"),
        )
    assert (unknown.code, holds_not.code, straight.code, nobody.code) == (2, 2, 2, 3)
    assert all(condition in unknown.err for condition in TapCondition)
    assert "a condition that holds the message: BeforeAchieving" in holds_not.err
    assert "AfterReplied" in straight.err
    assert "Did you mean 'where'" in nobody.err


async def test_a_task_is_suspended_and_resumed():
    async with office() as here:
        task = await here.me.expand(Deliver(there="a", back="b"), id="d1")
        await eventually(lambda: drove(here, "a"))
        suspended = await here.tca("suspend", "d1")
        assert suspended.code == 0
        assert "suspended" in suspended.out
        assert "planned, suspended" in (await here.tca("tree", "d1")).out
        await here.me.inform(Arrive())
        await eventually(lambda: holds_the_way_to(here, "b"))
        resumed = await here.tca("resume", "d1", "--json")
        assert (resumed.code, resumed.json["suspended"]) == (0, False)
        assert await task.result(timeout=10.0) == "a and b"


async def drove(here, place):
    return await here.me.query(Where()) == place


async def holds_the_way_to(here, place):
    way = await here.me.relative("d1", "last_child")
    return way is not None and (way.data["to"], way.waiting_for) == (place, "being resumed")


async def test_a_task_is_handled_again_by_hand():
    async with office() as here:
        task = await here.me.execute(Drive(to="x"), id="d1")
        await eventually(lambda: drove(here, "x"))
        assert (await here.tca("retry", "d1")).code == 0
        await eventually(lambda: is_at_attempt(here, "d1", 2))
        assert "retried 1x" in (await here.tca("tree", "d1")).out
        await here.me.inform(Arrive())
        assert (await task.result(timeout=10.0)).attempt == 2


async def is_at_attempt(here, id, attempt):
    status = await status_of(here, id)
    return status.attempt == attempt and status.state == "active"


async def test_what_waits_is_put_in_another_order_by_hand():
    async with office() as here:
        first = await here.me.execute(Drive(to="a"), constraints=FREE)
        await eventually(lambda: drove(here, "a"))
        tasks = [await here.me.execute(Drive(to=to), constraints=FREE) for to in "bc"]
        moved = await here.tca("prioritize", tasks[1].id, "10")
        assert moved.code == 0
        assert "priority 10" in moved.out
        await here.tca("suspend", tasks[0].id)
        await here.me.inform(Arrive())
        await first.result(timeout=10.0)
        await tasks[1].result(timeout=10.0)
        assert (await status_of(here, tasks[0])).waiting_for == "being resumed"


BAD_INPUT = [
    (["suspend", "nothing"], 1, "no task 'nothing' here"),
    (["resume", "nothing"], 1, "no task 'nothing' here"),
    (["retry", "nothing"], 1, "no task 'nothing' here"),
    (["prioritize", "nothing", "1"], 1, "no task 'nothing' here"),
    (["prioritize", "nothing", "high"], 2, "high"),
    (["suspend", "no task"], 2, "id: string should match pattern"),
    (["suspend"], 2, "ID"),
]


async def test_bad_input_is_answered_with_what_was_wrong():
    async with office() as here:
        ran = await asyncio.gather(*(here.tca(*arguments) for arguments, _, _ in BAD_INPUT))
    for one, (arguments, code, text) in zip(ran, BAD_INPUT, strict=True):
        assert one.code == code, (arguments, one.err)
        assert text in one.err
