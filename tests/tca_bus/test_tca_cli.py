"""The ``tca`` command as its users have it: output, complaints and exit codes."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from contextlib import asynccontextmanager

import pytest
from bus_process import victim
from bus_victim import Toil
from central_robot import Arrive, Drive, robot
from command_line import Ran, run_command

from tca_bus import Module, Variable
from tca_bus._protocol import FindTask, ListTasks
from tca_bus.cli import _client
from tca_bus.cli.tca import app
from tca_bus.testing import bus, central, eventually

pytestmark = [pytest.mark.bus, pytest.mark.process]

BATTERY = Variable("battery", float)


class Office:
    """A bus with central and a robot, and the command line on it."""

    def __init__(self, options, me, robot=None):
        self.options = options
        self.me = me
        self.robot = robot
        self._started = []
        self._turn = asyncio.Lock()

    async def start(self, *arguments, stdin=asyncio.subprocess.DEVNULL, **environment):
        process = await asyncio.create_subprocess_exec(
            sys.executable,
            *("-m", "tca_bus", *arguments),
            stdin=stdin,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            env={**os.environ, **self._bus, **environment},
        )
        self._started.append(process)
        return process

    async def close(self):
        """End what a test that failed has left."""
        for process in self._started:
            if process.returncode is None:
                process.kill()
                await process.communicate()

    async def tca(self, *arguments, **environment):
        """Run a command to its end, here; one that is `start`ed is a process of its own."""
        async with self._turn:
            return await run_command(app, *arguments, **{**self._bus, **environment})

    @property
    def _bus(self):
        return {"TCA_CONNECT": self.options.connect, "TCA_REALM": self.options.realm}


async def finish(process):
    out, err = await process.communicate()
    return Ran(process.returncode, out.decode(), err.decode())


@asynccontextmanager
async def office():
    async with (
        bus() as options,
        central(options),
        robot("robot", options) as driven,
        Module("me", options=options) as me,
    ):
        await me.wait_for(Drive, "tca.submit", timeout=10.0)
        here = Office(options, me, driven)
        try:
            yield here
        finally:
            await here.close()


async def test_modules_and_messages_are_listed():
    async with office() as here:
        listed, table, shown, messages = await asyncio.gather(
            here.tca("modules", "--json"),
            here.tca("modules"),
            here.tca("messages", "drive", "--json"),
            here.tca("messages"),
        )
    (one,) = [module for module in listed.json if module["name"] == "robot"]
    assert list(one)[:5] == ["name", "pid", "host", "state", "provides"]
    assert list(one)[5:] == ["resources", "requires", "missing"]
    assert one["state"] == "ready"
    assert "drive" in one["provides"]
    assert "robot" in table.out
    assert shown.json["message_schema"]["required"] == ["to"]
    assert "Drive there and back." in messages.out


async def test_what_a_module_requires_and_nobody_provides_is_shown():
    async with office() as here:
        needy = Module(
            "needy", options=here.options, provides=["map"], requires=["sonar"], hold=True
        )
        async with needy:
            listed, table, doctor = await asyncio.gather(
                here.tca("modules", "--json"), here.tca("modules"), here.tca("doctor")
            )
    (one,) = [module for module in listed.json if module["name"] == "needy"]
    assert (one["state"], one["resources"]) == ("held", ["map"])
    assert (one["requires"], one["missing"]) == (["sonar"], ["sonar"])
    assert "missing" in table.out
    assert "needy: requires 'sonar', which no module provides" in doctor.out


async def test_queries_and_one_way_messages():
    async with office() as here:
        asked, alone = await asyncio.gather(
            here.tca("query", "where"), here.tca("broadcast", "anything")
        )
        assert asked.json == "home"
        assert (await here.tca("inform", "ring", '{"times": 3}')).code == 0
        await eventually(lambda: rang(here))
        assert alone.code == 0
        assert "no module handles" in alone.err


async def rang(here):
    return (await here.me.query_json("where", {})) == "rang 3"


BAD_INPUT = [
    (["query", "where", "{"], 2, "line 1 column 2"),
    (["query", "where", '{"x": 1}'], 2, "x: extra inputs are not permitted"),
    (["query", "wher"], 3, "Did you mean 'where'"),
    (["query", "drive"], 2, "use 'tca command drive'"),
    (["inform", "ring", '{"time": 1}'], 2, "time: no such field, expected times"),
    (["command", "quick", '{"number": -1}'], 1, "-1 is below zero (negative)"),
    (["command", "quik"], 3, "Did you mean 'quick'"),
    (["goal", "deliver", "{}", "--timeout", "soon"], 2, "--timeout"),
    (["kill", "nothing"], 1, "no task 'nothing' here"),
    (["kill", "root"], 7, "the root"),
    (["kill", "no task"], 2, "id: string should match pattern"),
    (["log", "never"], 1, "no task 'never' here"),
    (["log", "--last", "-1"], 2, "--last"),
    (["log", "--letters", "mz"], 2, "expected letters of: m (messages and constraints)"),
    (["modules", "--realm", "a/b"], 2, "realm is 'a/b'"),
    (["var", "get", "batery"], 1, "'batery' was never set. Did you mean 'battery'"),
    (["var", "set", "battery", '"full"'], 2, "value: expected number, got 'full'"),
    (["central"], 7, "is central there"),
    (["router"], 2, "something listens there already"),
]


async def test_bad_input_ends_with_one_clear_line():
    async with office() as here:
        await here.me.set(BATTERY, 12.5)
        ran = [await here.tca(*arguments) for arguments, _, _ in BAD_INPUT]
        assert await here.me.query_json("where", {}) == "home"
    for (arguments, code, text), one in zip(BAD_INPUT, ran, strict=True):
        complaints = [line for line in one.err.splitlines() if line.startswith("error: ")]
        assert (one.code, len(complaints)) == (code, 1), (arguments, one.err)
        assert text in complaints[0]
        assert "Traceback" not in one.err


async def test_tasks_are_sent_waited_for_and_shown():
    async with office() as here:
        done = await here.tca("command", "quick", '{"number": 4}')
        assert (done.code, done.json) == (0, 4)
        sent = await here.tca("command", "drive", '{"to": "r-5303"}', "--no-wait", "--id", "d1")
        assert sent.out.strip() == "d1"
        await eventually(lambda: runs(here))
        tree, nodes = await asyncio.gather(here.tca("tree"), here.tca("tree", "--alive", "--json"))
        assert "● drive d1  active" in tree.out
        assert "✓ quick" in tree.out
        assert [(node["id"], node["data"]) for node in nodes.json] == [("d1", {"to": "r-5303"})]
        await here.me.inform(Arrive())
        again = await here.tca("command", "drive", '{"to": "r-5303"}', "--id", "d1", "--json")
        assert again.json["state"] == "achieved"
        log = (await here.tca("log", "--json")).json_lines
        assert [line["event"] for line in log if line["task"] == "d1"] == [
            "submitted",
            "dispatched",
            "started",
            "handled",
            "achieved",
        ]


async def test_a_wait_that_is_too_long_ends_and_the_task_goes_on():
    async with office() as here:
        ran = await here.tca("command", "drive", '{"to": "x"}', "--timeout", "0.2", "--id", "d1")
        assert ran.code == 4
        assert "'tca kill d1' ends it" in ran.err
        killed = await here.tca("kill", "d1", "--reason", "enough", "--json")
        assert (killed.code, killed.json["id"]) == (0, "d1")
        await eventually(lambda: is_killed(here, "d1"))


async def is_killed(here, id):
    return (await here.me.query(FindTask(id=id))).state == "killed"


async def test_a_task_whose_module_dies_goes_to_the_next_one_if_asked_for():
    async with office() as here:
        relief = Module("relief", options=here.options)

        @relief.handler(Toil)
        async def toil(message, context):
            return context.attempt

        async with victim(here.options) as process:
            await here.me.wait_for(Toil, timeout=20.0)
            sending = asyncio.create_task(
                here.tca("command", "toil", "--on-module-lost", "resend"), name="sending"
            )
            await eventually(lambda: runs(here))
            process.kill()
        async with relief:
            ran = await sending
    assert (ran.code, ran.json) == (0, 2)


async def test_an_interrupt_kills_the_task_that_was_sent():
    async with office() as here:
        process = await here.start("command", "drive", '{"to": "x"}', "--id", "d1")
        await eventually(lambda: runs(here))
        process.send_signal(signal.SIGINT)
        ran = await finish(process)
        assert ran.code == 6
        assert "interrupted: task d1" in ran.err
        await eventually(lambda: is_killed(here, "d1"))


async def runs(here):
    return any(status.state == "active" for status in await here.me.query(ListTasks()))


async def test_a_killed_task_has_an_exit_code_of_its_own():
    async with office() as here:
        sending = asyncio.create_task(
            here.tca("command", "drive", '{"to": "x"}', "--id", "d1"), name="sending"
        )
        await eventually(lambda: runs(here))
        await here.me.kill("d1", reason="no more")
        ran = await sending
        assert ran.code == 6
        assert "task d1 was killed: no more" in ran.err


async def test_the_history_is_followed_line_by_line():
    async with office() as here:
        process = await here.start("log", "--follow", "--json")
        await here.me.execute(Drive(to="x"), id="d1")
        async with asyncio.timeout(20.0):
            first = json.loads(await process.stdout.readline())
        assert (first["task"], first["event"]) == ("d1", "submitted")
        process.terminate()
        assert (await finish(process)).code == 0


async def test_changes_of_the_tree_are_watched():
    async with office() as here:
        await here.me.execute(Drive(to="x"), id="d1")
        process = await here.start("tree", "--watch", "--json")
        async with asyncio.timeout(20.0):
            first = json.loads(await process.stdout.readline())
            await here.me.kill("d1", reason="no more")
            while json.loads(await process.stdout.readline())["state"] != "killed":
                pass
        assert first["id"] == "d1"
        process.terminate()
        assert (await finish(process)).code == 0


async def test_doctor_and_status_say_what_of_the_office_is_missing():
    async with bus() as options, central(options), Module("me", options=options) as me:
        await me.wait_for("tca.submit", timeout=10.0)
        here = Office(options, me)
        status, doctor = await asyncio.gather(here.tca("status", "--json"), here.tca("doctor"))
        assert status.code == 1
        assert status.json["modules"]["central"] == "ready"
        assert status.json["modules"]["navigate"] == "missing"
        assert doctor.code == 1
        assert "ok  central: ready" in doctor.out
        assert "start it with 'navigate run'" in doctor.out


async def test_doctor_and_status_want_of_another_robot_only_central():
    async with office() as here:
        status, doctor = await asyncio.gather(here.tca("status", "--json"), here.tca("doctor"))
    assert (status.code, doctor.code) == (0, 0)
    lasting = {name for name in status.json["modules"] if not name.startswith("tca-")}
    assert lasting == {"central", "robot", "me"}
    assert "navigate" not in doctor.out


async def test_without_central_it_says_how_to_start_one(monkeypatch):
    monkeypatch.setattr(_client, "CENTRAL_GRACE", 0.2)
    async with bus() as options, robot("robot", options), Module("me", options=options) as me:
        here = Office(options, me)
        ran = await asyncio.gather(
            here.tca("tree"), here.tca("kill", "x"), here.tca("command", "quick", '{"number": 1}')
        )
    for one in ran:
        assert one.code == 3
        assert "Start it with 'tca central'" in one.err


async def test_a_reader_that_leaves_is_no_error():
    async with office() as here:
        process = await asyncio.create_subprocess_shell(
            f"{sys.executable} -m tca_bus messages --connect {here.options.connect} "
            f"--realm {here.options.realm} --json | head -c 10",
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
        )
        ran = await finish(process)
        assert ran.err == ""


async def test_flags_beat_the_environment_which_beats_the_file(tmp_path):
    file = tmp_path / "tca.toml"
    file.write_text('realm = "elsewhere"\njson = true\n')
    named = {"TCA_CONFIG": str(file)}
    async with office() as here:
        of_environment, of_flag = await asyncio.gather(
            here.tca("modules", **named), here.tca("modules", "--realm", "nobody", **named)
        )
    assert {module["name"] for module in of_environment.json} >= {"central", "robot", "me"}
    assert of_flag.json == []


async def test_a_router_runs_until_its_parent_is_gone():
    reading, writing = os.pipe()
    process = await asyncio.create_subprocess_exec(
        sys.executable,
        *("-m", "tca_bus", "router", "--connect", "tcp/127.0.0.1:0"),
        stderr=asyncio.subprocess.PIPE,
        pass_fds=[reading],
        env={**os.environ, "TCA_PARENT_FD": str(reading)},
    )
    os.close(reading)
    async with asyncio.timeout(20.0):
        assert b"router listens at tcp/127.0.0.1:" in await process.stderr.readline()
        os.close(writing)
        assert await process.wait() == 0


async def test_variables_are_set_read_swapped_listed_and_watched():
    async with office() as here:
        watching = await here.start("var", "watch", "battery")
        await here.me.set(BATTERY, 12.5)
        assert await watching.stdout.readline() == b"12.5\n"
        read, listed = await asyncio.gather(
            here.tca("var", "get", "battery", "--json"), here.tca("var", "list")
        )
        assert (read.json["value"], read.json["sequence"], read.json["writer"]) == (12.5, 1, "me")
        assert "12.5" in listed.out
        assert (await here.tca("var", "swap", "battery", "12")).json == 12.5
        assert await watching.stdout.readline() == b"12\n"
        assert (await here.tca("var", "set", "battery", "11", "--expected", "2")).out == "3\n"
        refused = await here.tca("var", "set", "battery", "10", "--expected", "2")
        assert (refused.code, "expected sequence 2, found 3" in refused.err) == (1, True)
        assert await here.me.get(BATTERY) == 11
        watching.send_signal(signal.SIGINT)
        assert (await finish(watching)).code == 6
