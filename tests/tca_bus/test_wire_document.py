"""``docs/wire.md`` is enough to take part: its program runs, its tables are true."""

from __future__ import annotations

import asyncio
import re
import sys
from pathlib import Path
from typing import get_args

import pytest
from central_robot import Arrive, office

from tca_bus import PresentModule, TaskState
from tca_bus._envelope import Envelope
from tca_bus._faults import FAILED, SAME_CLASS
from tca_bus._keys import Keys
from tca_bus._messages import ModuleLostPolicy
from tca_bus._protocol import ListTasks, SubmitTask, TaskStatus
from tca_bus.testing import eventually

TEXT = (Path(__file__).parents[2] / "docs" / "wire.md").read_text(encoding="utf-8")
PROGRAM = re.search(r"```python\n(.*?)```", TEXT, re.DOTALL)[1]

WITHOUT_US = "import sys; sys.modules['tca_bus'] = None; exec(sys.argv.pop(1))"


def rows(heading):
    """The first words of the table below a heading or phrase."""
    table = TEXT.split(heading, 1)[1].split("\n|", 1)[1].split("\n\n", 1)[0]
    return re.findall(r"^\|? ?`([^`]+)`", table, re.MULTILINE)


@pytest.mark.bus
@pytest.mark.process
@pytest.mark.parametrize("arrives", [True, False])
async def test_a_stranger_asks_sends_and_follows_with_what_is_written(arrives):
    async with office() as me:
        options = me.options
        stranger = await asyncio.create_subprocess_exec(
            *(sys.executable, "-c", WITHOUT_US, PROGRAM, options.connect, options.realm),
            stdout=asyncio.subprocess.PIPE,
        )
        active = await active_task(me)
        await (me.inform(Arrive()) if arrives else me.kill(active.id, reason="no"))
        output, _ = await stranger.communicate()
    lines = output.decode().splitlines()
    assert stranger.returncode == 0
    assert lines[0] == "it is at home"
    assert "drive is active" in lines
    end = "drive has achieved {" if arrives else "drive has killed {'name': 'killed', 'text': 'no'"
    assert lines[-1].startswith(end)


async def active_task(me):
    found = []

    async def look():
        found[:] = [task for task in await me.query(ListTasks()) if task.state is TaskState.ACTIVE]
        return found

    await eventually(look, what="the stranger's command to run")
    return found[0]


def test_the_program_does_without_us():
    assert "tca_bus" not in PROGRAM


def test_the_keys_are_those_that_modules_use():
    keys = Keys("REALM")
    module = PresentModule("CALLEE", "INCARNATION", "HOST", 1, ("NAMES",))
    assert set(rows("## Keys")) == {
        re.sub("/1/NAMES/.*", "/PID/NAMES/MORE", keys.presence(module)).replace("CALLEE", "MODULE"),
        keys.query(module, "NAME", "CALLER"),
        keys.one_way("inform", "NAME", "SENDER"),
        keys.one_way("broadcast", "NAME", "SENDER"),
        keys.task("SENDER", "ID"),
        keys.variable("NAME"),
    }


def test_the_fields_are_those_that_there_are():
    assert set(rows("## Attachment")) == set(Envelope.model_fields)
    assert set(rows("`tca.submit` takes")) <= set(SubmitTask.model_fields)
    assert set(rows("has among others")) <= set(TaskStatus.model_fields)
    required = {name for name, field in SubmitTask.model_fields.items() if field.is_required()}
    assert required <= set(rows("`tca.submit` takes"))


def test_states_and_errors_are_all_named():
    assert all(f"`{state.value}`" in TEXT for state in TaskState)
    assert all(f"`{kind}`" in TEXT for kind in (*SAME_CLASS, FAILED))
    assert all(f"`{policy}`" in TEXT for policy in get_args(ModuleLostPolicy))
