"""For each right: a module without it is refused at once, by the real router, over TLS.

Each is tried twice: by a module that asks the policy first, as all do, and where the wire is
what stops it, by a careless one that does not.
"""

from __future__ import annotations

import asyncio

import pytest
from security_office import (
    REALM,
    Add,
    Drive,
    Note,
    Plan,
    Scan,
    Secret,
    Sum,
    Survey,
    careless,
    guarded,
    make_keys,
    with_central,
)

from tca_bus import Context, PeerLostError, Query, RefusedError, TaskFailedError, TcaError
from tca_bus._protocol import (
    FindTask,
    HandleTask,
    KillTask,
    ListTasks,
    ReadLog,
    ReportOutcome,
    SubmitTask,
)
from tca_bus._rights import Right
from tca_bus._time_messages import SimulatedTime
from tca_bus._wire import Payload
from tca_bus.testing import eventually

pytestmark = pytest.mark.bus

POLICY = {
    "modules": {
        "server": {
            "serve": ["add", "survey", "note", "drive", "plan"],
            "listen": ["scan@robot"],
        },
        "asker": {"send": ["add", "survey", "note", "drive", "plan", "scan"]},
        "robot": {"send": ["scan", "tca.simTime"], "kill": ["drive@asker"], "watch": ["asker"]},
        "nobody": {},
        "tca": {"send": ["*"], "listen": ["*"], "watch": ["*"], "kill": ["*"]},
    }
}


@pytest.fixture(scope="session")
def keys(tmp_path_factory):
    return make_keys(tmp_path_factory.mktemp("guarded") / "keys", *POLICY["modules"])


@pytest.fixture
async def office(keys):
    async with guarded(keys, POLICY) as office:
        yield office


class Server:
    """Serves all that the server may, and notes what reached it."""

    def __init__(self, module):
        self.module = module
        self.seen = []
        self.release = asyncio.Event()
        module.serve(Add, self.add)
        module.serve(Survey, self.survey)
        module.serve(Note, self.note)
        module.serve(Scan, self.scan)
        module.serve(Drive, self.drive, capacity=5)
        module.serve(Plan, self.plan)

    async def add(self, message, context):
        self.seen.append(f"add from {context.sender}")
        return Sum(value=message.a + message.b)

    async def survey(self, message, context):
        return "here"

    async def note(self, message, context):
        self.seen.append(f"note {message.text} from {context.sender}")

    async def scan(self, message, context):
        self.seen.append(f"scan {message.text} from {context.sender}")

    async def drive(self, message, context):
        await self.release.wait()
        return message.where

    async def plan(self, message, context):
        return "planned"


async def assert_refused(awaitable, *words):
    with pytest.raises(RefusedError) as caught:
        await awaitable
    for word in words:
        assert word in str(caught.value)
    assert caught.value.exit_code == 7


async def test_with_the_rights_everything_works(office):
    async with office.module("server") as module, office.module("asker") as asker:
        server = Server(module)
        await asker.wait_for(Add, Note, timeout=10)
        assert await asker.query(Add(a=1, b=2)) == Sum(value=3)
        assert [answer async for answer in asker.query_all(Survey())] == ["here"]
        await asker.inform(Note(text="x"))
        async with office.module("robot") as robot:
            await robot.broadcast(Scan(text="y"))
            await eventually(lambda: server.seen[1:] == ["note x from asker", "scan y from robot"])


async def test_send_query_without_the_right(office):
    async with office.module("server") as module, office.module("nobody") as nobody:
        server = Server(module)
        await nobody.wait_for(Add, timeout=10)
        await assert_refused(
            nobody.query(Add(a=1, b=2)), "nobody", "send 'add'", "nothing of that kind"
        )
        await assert_refused(nobody.query_json("add", {"a": 1, "b": 2}), "send 'add'")
        await assert_refused(anext(nobody.query_all(Survey())), "send 'survey'")
        assert server.seen == []


async def test_send_inform_and_broadcast_without_the_right(office):
    async with office.module("server") as module, office.module("nobody") as nobody:
        server = Server(module)
        await nobody.wait_for(Note, timeout=10)
        await assert_refused(nobody.inform(Note()), "send 'note'")
        await assert_refused(nobody.broadcast(Scan()), "send 'scan'")
        assert server.seen == []


async def test_the_router_stops_what_a_careless_module_sends(office):
    nobody = careless(office.module("nobody"))
    async with office.module("server") as module, office.module("asker") as asker, nobody:
        server = Server(module)
        await nobody.wait_for(Add, Note, timeout=10)
        await asker.wait_for(Add, Note, timeout=10)
        with pytest.raises(PeerLostError):
            await nobody.query(Add(a=1, b=2), timeout=5)
        await nobody.inform(Note(text="forbidden"))
        await asker.inform(Note(text="allowed"))
        await eventually(lambda: "note allowed from asker" in server.seen)
        assert server.seen == ["note allowed from asker"]


async def test_nobody_can_send_under_the_name_of_another(office):
    nobody = careless(office.module("nobody"))
    async with office.module("server") as module, office.module("asker") as asker, nobody:
        server = Server(module)
        await asker.wait_for(Note, timeout=10)
        session = nobody._parts.core.session
        note = Payload(b'{"text": "forged"}', "")
        session.put(f"{REALM}/inform/note/asker", note, attachment=b'{"id": "1"}', block=True)
        (callee,) = (m for m in asker.modules() if m.name == "server")
        key = f"{REALM}/query/server/{callee.incarnation}/add/asker"
        add = Payload(b'{"a": 1, "b": 2}', "")
        assert await session.ask(key, add, attachment=b'{"id": "2"}', timeout=5) is None
        await asker.inform(Note(text="own"))
        await eventually(lambda: server.seen)
        assert server.seen == ["note own from asker"]


async def test_serve_without_the_right(office):
    async def handler(message, context):
        return "never"

    async with office.module("server") as server:
        with pytest.raises(RefusedError, match="to serve 'secret'"):
            server.serve(Secret, handler)
        assert (
            "secret" not in (await server.query_json("tca.describe", {}, to="server"))["provides"]
        )
    before = office.module("server")
    before.serve(Secret, handler)
    with pytest.raises(RefusedError, match="to serve 'secret'"):
        async with before:
            pass


async def test_nobody_asks_a_careless_module_for_what_it_may_not_serve(office):
    impostor = careless(office.module("nobody"))
    served = []

    async def add(message, context):
        served.append(message)
        return Sum(value=0)

    impostor.serve(Add, add)
    async with impostor, office.module("server") as module, office.module("asker") as asker:
        Server(module)
        await asker.wait_for(Add, timeout=10)
        await eventually(lambda: "nobody" in {m.name for m in asker.modules()})
        provides = {m.name: m.provides for m in asker.modules()}
        assert provides["nobody"] == ()
        for _ in range(5):
            assert await asker.query(Add(a=1, b=2)) == Sum(value=3)
        with pytest.raises(TcaError):
            await asker.query(Add(a=1, b=2), to="nobody", timeout=2)
        assert served == []


async def test_listen_without_the_right(office):
    async with office.module("nobody") as nobody, office.module("tca-7") as tca:
        with pytest.raises(RefusedError, match="to listen 'scan'"):
            async with nobody.subscribe(Scan):
                pass
        with pytest.raises(RefusedError, match="to listen 'note'"):
            async with nobody.subscribe(Note):
                pass
        async with tca.subscribe(Scan), tca.subscribe(Note):
            pass


async def test_the_router_lets_a_careless_module_hear_nothing(office):
    nobody = careless(office.module("nobody"))
    async with (
        nobody,
        office.module("tca") as tca,
        office.module("robot") as robot,
        nobody.subscribe(Scan) as deaf,
        tca.subscribe(Scan) as hears,
    ):
        await robot.broadcast(Scan(text="secret"))
        assert (await asyncio.wait_for(hears.get(), 10)).text == "secret"
        # What is sent to a module on one link arrives in order.
        await nobody._parts.core.session.settle(f"{REALM}/presence/**")
        assert deaf.waiting == 0


async def test_listening_to_one_sender_is_to_hear_no_other(office):
    async with office.module("server") as module, office.module("asker") as asker:
        server = Server(module)
        await asker.wait_for(Note, timeout=10)
        async with office.module("robot") as robot:
            await asker.broadcast(Scan(text="not for it"))
            await robot.broadcast(Scan(text="for it"))
            await asker.inform(Note(text="end"))
            await eventually(lambda: len(server.seen) == 2)
            assert "scan not for it from asker" not in server.seen


async def test_only_who_may_makes_the_time(office):
    async with office.module("robot") as robot, office.module("tca") as tca:
        await robot.broadcast(SimulatedTime(time=1.0, speed=None))
        await assert_refused(tca.broadcast(SimulatedTime(time=2.0, speed=None)), "tca.simTime")


async def test_the_router_lets_a_careless_module_make_no_time(office):
    tca = careless(office.module("tca"))
    async with (
        tca,
        office.module("robot") as robot,
        office.module("nobody") as nobody,
        nobody.subscribe(SimulatedTime) as times,
    ):
        await tca.broadcast(SimulatedTime(time=2.0, speed=None))
        await tca._parts.core.session.settle(f"{REALM}/presence/**")
        await robot.broadcast(SimulatedTime(time=1.0, speed=None))
        assert (await asyncio.wait_for(times.get(), 10)).time == 1.0


async def test_send_goal_and_command_without_the_right(keys):
    async with with_central(keys, POLICY) as (office, _), office.module("server") as module:
        Server(module)
        async with office.module("nobody") as nobody:
            await assert_refused(nobody.execute(Drive(), wait_for_handler=5), "send 'drive'")
            await assert_refused(nobody.expand(Plan(), wait_for_handler=5), "send 'plan'")


async def test_central_stops_the_tasks_of_a_careless_module(keys):
    async with with_central(keys, POLICY) as (office, central), office.module("server") as module:
        Server(module)
        async with careless(office.module("nobody")) as nobody:
            await assert_refused(
                nobody.execute(Drive(), wait_for_handler=5), "send 'drive'", "nobody"
            )
            forged = SubmitTask(
                id="nobody-1", name="drive", task_class="command", data={}, sender="asker"
            )
            await assert_refused(nobody.query(forged, to="central"), "comes from 'nobody'")
            assert len(central.tree) == 0


async def test_a_child_needs_a_hand_in_its_parent(keys):
    async with with_central(keys, POLICY) as (office, _), office.module("server") as module:
        server = Server(module)
        async with office.module("asker") as asker, careless(office.module("tca")) as tca:
            parent = await asker.execute(Drive(), wait_for_handler=5)
            await eventually(lambda: parent.status.handler == "server")
            child = SubmitTask(
                id="tca-1",
                name="drive",
                task_class="command",
                data={},
                sender="tca",
                parent=parent.id,
            )
            await assert_refused(tca.query(child, to="central"), "edit 'drive' of 'asker'")
            server.release.set()
            assert await parent.result(timeout=10) == "here"


async def test_a_careless_module_gets_no_tasks_that_it_may_not_serve(keys):
    impostor = None
    async with with_central(keys, POLICY) as (office, _), office.module("asker") as asker:
        impostor = careless(office.module("nobody"))

        async def drive(message, context):
            return "stolen"

        impostor.serve(Drive, drive)
        async with impostor:
            task = await asker.execute(Drive(), wait_for_handler=30)
            async with office.module("server") as module:
                server = Server(module)
                server.release.set()
                assert await task.result(timeout=20) == "here"


async def test_kill_without_the_right(keys):
    async with with_central(keys, POLICY) as (office, _), office.module("server") as module:
        Server(module)
        async with office.module("asker") as asker, office.module("nobody") as nobody:
            task = await asker.execute(Drive(), wait_for_handler=5)
            await assert_refused(
                nobody.kill(task.id, reason="x"), "kill 'drive' of 'asker'", "nobody"
            )
            await assert_refused(nobody.kill("asker-unknown", reason="x"), "kill")
            kill = KillTask(id=task.id)
            await assert_refused(careless(nobody).query(kill, to="central"), "kill 'drive'")
            assert not (await asker.query(FindTask(id=task.id), to="central")).is_ended
            async with office.module("robot") as robot:
                await robot.kill(task.id, reason="it may")
            await eventually(lambda: task.status.is_ended)


async def test_a_module_may_kill_what_it_sent_itself(keys):
    async with with_central(keys, POLICY) as (office, _), office.module("server") as module:
        Server(module)
        async with office.module("asker") as asker:
            task = await asker.execute(Drive(), wait_for_handler=5)
            await task.kill("no more")
            await eventually(lambda: task.status.is_ended)


async def test_watch_without_the_right(keys):
    async with with_central(keys, POLICY) as (office, _), office.module("server") as module:
        server = Server(module)
        async with office.module("asker") as asker, office.module("nobody") as nobody:
            with pytest.raises(RefusedError, match="to watch 'asker'"):
                async with nobody.watch_statuses(sender="asker"):
                    pass
            with pytest.raises(RefusedError, match=r"to watch '\*'"):
                async with nobody.watch_statuses():
                    pass
            task = await asker.execute(Drive(), wait_for_handler=5)
            await assert_refused(nobody.query(FindTask(id=task.id), to="central"), "watch 'asker'")
            await assert_refused(nobody.query(ReadLog(), to="central"), "watch the tasks of all")
            await assert_refused(nobody.query(ReadLog(task=task.id), to="central"), "watch 'asker'")
            assert await nobody.query(ListTasks(), to="central") == []
            assert len(await asker.query(ListTasks(), to="central")) == 1
            assert (await module.query(FindTask(id=task.id), to="central")).id == task.id
            server.release.set()
            await task.result(timeout=10)


async def test_the_router_shows_a_careless_module_no_task(keys):
    async with with_central(keys, POLICY) as (office, _), office.module("server") as module:
        server = Server(module)
        nobody = careless(office.module("nobody"))
        async with (
            nobody,
            office.module("asker") as asker,
            office.module("robot") as robot,
            nobody.watch_statuses() as deaf,
            robot.watch_statuses(sender="asker") as sees,
        ):
            task = await asker.execute(Drive(), wait_for_handler=5)
            server.release.set()
            await task.result(timeout=10)
            assert (await asyncio.wait_for(sees.get(), 10)).id == task.id
            await nobody._parts.core.session.settle(f"{REALM}/presence/**")
            assert deaf.waiting == 0
            key = f"{REALM}/task/asker/{task.id}"
            assert await look(nobody, key) is None
            assert await look(robot, key) is not None


async def look(module, key):
    """Get a key as a plain Zenoh tool would."""
    session = module._parts.core.session
    return await session.ask(key, Payload(b"", ""), attachment=b"", timeout=5)


async def test_only_central_gives_out_tasks(keys):
    async with with_central(keys, POLICY) as (office, _), office.module("server") as module:
        Server(module)
        order = HandleTask(
            id="tca-1", attempt=1, name="drive", task_class="command", data={}, sender="asker"
        )
        async with office.module("tca") as tca:
            await assert_refused(
                tca.query(order, to="server"), "only central may send 'tca.handle'"
            )
        async with careless(office.module("tca")) as tca:
            with pytest.raises(PeerLostError):
                await tca.query(order, to="server", timeout=5)


async def test_only_the_handler_reports_an_outcome(keys):
    async with with_central(keys, POLICY) as (office, _), office.module("server") as module:
        server = Server(module)
        async with office.module("asker") as asker, office.module("tca") as tca:
            task = await asker.execute(Drive(), wait_for_handler=5)
            await eventually(lambda: task.status.handler == "server")
            forged = ReportOutcome(
                id=task.id, attempt=task.status.attempt, outcome="success", result="forged"
            )
            await assert_refused(tca.query(forged, to="central"), "'server' handles it")
            server.release.set()
            assert await task.result(timeout=10) == "here"


class Ask(Query[None]):
    """May the sender do this? Stands for what central does when it is asked for it."""

    wire_name = "tca.askForRight"

    right: Right
    name: str
    owner: str | None = None


@pytest.mark.parametrize("right", Right)
async def test_central_knows_who_asks_for_what(keys, right):
    pattern = f"good{'@asker' if right.is_owned else ''}" if right != Right.WATCH else "asker"
    policy = {"modules": {"asker": {}, "robot": {right.value: [pattern]}}}
    name, owner = ("asker", None) if right == Right.WATCH else ("good", "asker")
    async with with_central(keys, policy) as (office, central):

        async def answer(message: Ask, context: Context) -> None:
            check = central.permissions.check
            check(context.sender, message.right, message.name, owner=message.owner)

        central.module.serve(Ask, answer)
        async with office.module("robot") as robot, careless(office.module("asker")) as asker:
            await robot.query(Ask(right=right, name=name, owner=owner), to="central")
            for whose in ("asker", "nobody"):
                ask = Ask(right=right, name="bad", owner=whose)
                await assert_refused(robot.query(ask, to="central"), right.value, "bad")
            ask = Ask(right=right, name=name.replace("asker", "robot"), owner="robot")
            await assert_refused(asker.query(ask, to="central"), right.value, "'asker'")


async def test_a_failure_in_a_child_that_was_refused_is_the_parents(keys):
    policy = {"modules": {**POLICY["modules"], "server": {"serve": ["plan", "drive"]}}}
    async with with_central(keys, policy) as (office, _), office.module("server") as module:

        async def plan(message, context):
            await context.execute(Drive())

        module.serve(Plan, plan)
        async with office.module("asker") as asker:
            task = await asker.expand(Plan(), wait_for_handler=5)
            with pytest.raises(TaskFailedError) as caught:
                await task.result(timeout=10)
            assert caught.value.failure.name == "refused"
            assert "send 'drive'" in caught.value.failure.text
