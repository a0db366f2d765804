"""What a message type says of its tasks holds also for those that are sent by wire name."""

from __future__ import annotations

import pytest

from tca_bus import Command, Module, TaskContext, TcaException, clean_up, tap
from tca_bus._protocol import Describe, SubmitTask
from tca_bus._traits import TaskTraits, traits_of
from tca_bus.testing import bus, central, eventually


class Hasty(Command[str]):
    """Is stopped quickly, and only by its own module."""

    grace = 0.5
    priority = 3
    on_module_lost = "hold"
    on_unhandled = "go_on"


TRAITS = TaskTraits(priority=3, grace=0.5, on_module_lost="hold", on_unhandled="go_on")


def test_traits_are_those_of_the_type():
    assert traits_of(Hasty) == TRAITS
    assert traits_of(TcaException) == TaskTraits()


def test_what_central_sends_for_somebody_keeps_them():
    assert clean_up(Hasty()).sending.traits == TRAITS
    assert tap("WhenSent", Hasty).listener.priority == 3
    assert tap("WhenSent", Hasty, priority=1).listener.priority == 1


@pytest.mark.bus
async def test_a_task_sent_by_its_name_is_carried_out_as_one_sent_by_its_type():
    sent: list[SubmitTask] = []
    async with bus() as options, central(options):
        worker = Module("worker", options=options)

        @worker.handler(Hasty)
        async def hasty(_: Hasty, __: TaskContext) -> str:
            return "done"

        async with worker, Module("asker", options=options) as asker:
            await asker.wait_for(Hasty, timeout=10.0)
            card = await asker.query(Describe(), to="worker")
            (told,) = [message for message in card.provides if message.name == "hasty"]
            assert told.traits == TRAITS
            submit = asker._parts.sender.submit

            async def note(task, *arguments, **options):
                sent.append(task)
                return await submit(task, *arguments, **options)

            asker._parts.sender.submit = note
            by_type = await asker.execute(Hasty())
            by_name = await asker.submit_json(
                "hasty", {}, task_class="command", revision=1, traits=told.traits, priority=5
            )
            assert await by_type.result(timeout=10.0) == await by_name.result(timeout=10.0)
            await eventually(lambda: len(sent) == 2)
    same = {"id", "priority"}
    assert sent[0].model_dump(exclude=same) == sent[1].model_dump(exclude=same)
    assert [task.priority for task in sent] == [3, 5]
