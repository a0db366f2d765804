"""For each right over the tasks of others: a module without it is refused, over TLS."""

from __future__ import annotations

from contextlib import asynccontextmanager

import pytest
from security_office import Drive, make_keys, with_central

from tca_bus import RefusedError
from tca_bus._attachments import Catch, CleanUp, Sending, Tap, TapCondition
from tca_bus._monitor_spec import MonitorSpec
from tca_bus._orders import TaskRef
from tca_bus._protocol import SubmitTask
from tca_bus._tree_queries import (
    Attach,
    ConstrainTasks,
    Detach,
    FindRelative,
    ListAttachments,
    PrepareTask,
    PrioritizeTask,
    Relation,
    RetryTask,
    SuspendTask,
)
from tca_bus.testing import eventually

pytestmark = pytest.mark.bus

POLICY = {
    "modules": {
        "server": {"serve": ["drive", "alarm"]},
        "asker": {"send": ["drive", "alarm"], "edit": ["drive@asker"]},
        "nobody": {},
        "sender": {"send": ["drive", "alarm"]},
        "guard": {
            "send": ["alarm"],
            "suspend": ["drive@asker"],
            "prioritise": ["drive"],
            "edit": ["dri*"],
            "tap": ["drive"],
            "monitor": ["look"],
            "watch": ["*"],
        },
    }
}

ALARM = Sending(name="alarm", task_class="command")
TAP = Tap(id="tap", condition=TapCondition.WHEN_SENT, listener=ALARM)
TAP_ALL = TAP.model_copy(update={"id": "tap-all"})
CATCH = Catch(id="catch", handler="alarm")
CLEAN_UP = CleanUp(id="clean", sending=ALARM)


@pytest.fixture(scope="session")
def keys(tmp_path_factory):
    return make_keys(tmp_path_factory.mktemp("steering") / "keys", *POLICY["modules"])


@asynccontextmanager
async def task_of_asker(keys):
    """A task that the asker sent and that waits for its handler."""
    async with with_central(keys, POLICY) as (office, central), office.module("asker") as asker:
        task = await asker.execute(Drive(), wait_for_handler=60)
        yield office, central, asker, task


async def assert_refused(module, question, *words):
    with pytest.raises(RefusedError) as caught:
        await module.query(question, to="central")
    for word in words:
        assert word in str(caught.value)
    assert caught.value.exit_code == 7


def questions(id):
    later = TaskRef("other").achieving.end <= TaskRef(id).achieving.start
    return {
        "suspend": [SuspendTask(id=id), SuspendTask(id=id, resume=True)],
        "prioritise": [PrioritizeTask(id=id, priority=3)],
        "edit": [
            RetryTask(id=id),
            ConstrainTasks(orders=(later,)),
            Attach(to_task=id, what=CATCH),
            Attach(to_task=id, what=CLEAN_UP),
            Attach(to_message="drive", what=CATCH),
        ],
        "tap": [Attach(to_task=id, what=TAP), Attach(to_message="drive", what=TAP_ALL)],
    }


@pytest.mark.parametrize("right", ["suspend", "prioritise", "edit", "tap"])
async def test_without_the_right_it_is_refused(keys, right):
    async with task_of_asker(keys) as (office, central, _, task):
        before = central.tree.status(task.id)
        async with office.module("nobody") as nobody, office.module("sender") as sender:
            for question in questions(task.id)[right]:
                if right != "tap" and not isinstance(question, Attach):
                    await assert_refused(nobody, question, f"to {right} 'drive'", "'nobody'")
                await assert_refused(sender, question, f"to {right} 'drive'", "'sender'")
        assert central.tree.status(task.id) == before
        assert central.tree.attachments() == []


@pytest.mark.parametrize("right", ["suspend", "prioritise", "tap"])
async def test_with_the_right_it_is_done(keys, right):
    async with task_of_asker(keys) as (office, central, _, task), office.module("guard") as guard:
        done = []
        for question in questions(task.id)[right]:
            await guard.query(question, to="central")
            done.append(steered(central, task))
        assert done == STEERED[right]


def steered(central, task):
    """What can be seen of a task when it was steered."""
    status = central.tree.status(task.id)
    return status.suspended, status.priority, len(central.tree.attachments())


STEERED = {
    "suspend": [(True, 0, 0), (False, 0, 0)],
    "prioritise": [(False, 3, 0)],
    "tap": [(False, 0, 1), (False, 0, 2)],
}


async def test_with_the_right_a_tree_is_edited(keys):
    async with task_of_asker(keys) as (office, central, asker, task):
        other = await asker.execute(Drive(), wait_for_handler=60)
        async with office.module("guard") as guard:
            order = TaskRef(task.id).achieving.end <= TaskRef(other.id).achieving.start
            await guard.query(ConstrainTasks(orders=(order,)), to="central")
            await guard.query(Attach(to_task=task.id, what=CATCH), to="central")
            await guard.query(Attach(to_task=task.id, what=CLEAN_UP), to="central")
            assert len(central.tree.attachments()) == 2


async def test_the_sender_of_a_task_steers_it_without_a_right(keys):
    async with task_of_asker(keys) as (_, central, asker, task):
        await asker.query(SuspendTask(id=task.id), to="central")
        await asker.query(PrioritizeTask(id=task.id, priority=3), to="central")
        await asker.query(Attach(to_task=task.id, what=TAP), to="central")
        assert steered(central, task) == (True, 3, 1)
        await asker.query(SuspendTask(id=task.id, resume=True), to="central")
        assert steered(central, task) == (False, 3, 1)


async def test_what_central_sends_for_a_module_gives_it_no_right_to_send(keys):
    async with task_of_asker(keys) as (office, _, asker, task):
        drive = Sending(name="drive", task_class="command")
        async with office.module("guard") as guard:
            for what in (
                TAP.model_copy(update={"listener": drive}),
                CATCH.model_copy(update={"handler": "drive"}),
                CLEAN_UP.model_copy(update={"sending": drive}),
            ):
                await assert_refused(guard, Attach(to_task=task.id, what=what), "send 'drive'")
        forbidden = CLEAN_UP.model_copy(update={"sending": Sending(name="x", task_class="goal")})
        forged = submission("asker", attachments=(forbidden,))
        await assert_refused(asker, forged, "send 'x'")


def submission(sender, **fields):
    values = {"id": f"{sender}-1", "name": "drive", "task_class": "command", "data": {}}
    return SubmitTask(**(values | {"sender": sender} | fields))


async def test_a_task_brings_no_constraint_on_the_tasks_of_others(keys):
    async with task_of_asker(keys) as (office, _, _, task), office.module("sender") as sender:
        held = TaskRef("sender-1").achieving.end <= TaskRef(task.id).achieving.start
        await assert_refused(
            sender, submission("sender", orders=(held,)), "edit 'drive' of 'asker'"
        )
        after = TaskRef(task.id).achieving.end <= TaskRef("sender-1").achieving.start
        await sender.query(
            submission("sender", orders=(after,), wait_for_handler=60.0), to="central"
        )


async def test_a_place_in_the_tree_of_another_is_refused(keys):
    async with task_of_asker(keys) as (office, _, _, task), office.module("sender") as sender:
        place = {"id": "sender-2", "name": "drive", "task_class": "command", "sender": "sender"}
        await assert_refused(
            sender, PrepareTask(**place, parent=task.id), "edit 'drive' of 'asker'"
        )
        await assert_refused(sender, PrepareTask(**(place | {"name": "x"})), "send 'x'")
        await sender.query(PrepareTask(**place), to="central")


async def test_monitor_without_the_right(keys):
    async with task_of_asker(keys) as (office, _, _, _):
        monitor = {
            "name": "look",
            "task_class": "monitor",
            "monitor": MonitorSpec(kind="point", action=ALARM),
            "wait_for_handler": 60.0,
        }
        async with office.module("sender") as sender, office.module("guard") as guard:
            await assert_refused(sender, submission("sender", **monitor), "to monitor 'look'")
            drive = Sending(name="drive", task_class="command")
            other = monitor | {"monitor": MonitorSpec(kind="point", action=drive)}
            await assert_refused(guard, submission("guard", **other), "send 'drive'")
            await guard.query(submission("guard", **monitor), to="central")


async def test_only_who_attached_it_or_may_edit_detaches_it(keys):
    async with task_of_asker(keys) as (office, central, asker, task):
        await asker.query(Attach(to_task=task.id, what=TAP), to="central")
        async with office.module("sender") as sender:
            await assert_refused(sender, Detach(id="tap"), "to edit 'drive'")
        assert len(central.tree.attachments()) == 1
        assert await asker.query(Detach(id="tap"), to="central")


async def test_what_may_not_be_watched_is_not_shown_by_a_walk(keys):
    async with task_of_asker(keys) as (office, _, asker, task):
        await asker.query(Attach(to_task=task.id, what=TAP), to="central")
        walk = FindRelative(id=task.id, relation=Relation.TOP_LEVEL)
        async with office.module("sender") as sender, office.module("guard") as guard:
            await assert_refused(sender, walk, "watch 'asker'")
            assert await sender.query(ListAttachments(), to="central") == []
            assert (await guard.query(walk, to="central")).id == task.id
            assert len(await guard.query(ListAttachments(), to="central")) == 1
        await eventually(lambda: not task.status.is_ended)
