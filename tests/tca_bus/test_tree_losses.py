"""Losing modules (tca.md 3.14): their tasks fail, are sent again, or are held for their return."""

from __future__ import annotations

import asyncio

import pytest
from tree_office import Office

from tca_bus import BusOptions, Catch, Command, Module, TaskContext, TaskFailedError, TaskState
from tca_bus.tasktree import KillRequested, ProviderLost, WaitForHandler
from tca_bus.testing import ScriptedModule, eventually


def test_by_default_a_task_fails_and_a_handler_may_take_that():
    office = Office()
    office.command("A", flags=0)
    office.command("B", flags=0, attachments=[Catch(id="c", exception="module_lost", handler="f")])
    office.apply(ProviderLost, "r1")
    assert office.last["A"].failure.name == "module_lost"
    assert office.last["A"].failure.module is not None
    assert not office.last["B"].is_ended
    assert len(office.sent("f")) == 1


def test_one_that_is_held_goes_to_a_module_of_the_same_name_only():
    office = Office()
    office.command("A", on_module_lost="hold")
    effects = office.apply(ProviderLost, "r1")
    assert not [effect for effect in effects if isinstance(effect, WaitForHandler)]
    office.appear("stranger", "s1")
    assert office.tree.status("A").waiting_for == "module 'robot' to be back"
    office.appear("robot", "r2")
    assert office.handling("A")
    assert (office.last["A"].handler, office.last["A"].attempt) == ("robot", 2)


def test_one_that_is_held_can_be_killed():
    office = Office()
    office.command("A", on_module_lost="hold")
    office.apply(ProviderLost, "r1")
    office.apply(KillRequested, "A", "it will not be back")
    assert office.state("A") is TaskState.KILLED


def test_one_that_was_being_killed_is_not_sent_again():
    office = Office()
    office.command("A", on_module_lost="resend")
    office.apply(KillRequested, "A", "enough")
    office.apply(ProviderLost, "r1")
    assert office.state("A") is TaskState.KILLED


def test_a_parent_s_failure_knows_what_failed_below_it():
    office = Office()
    office.goal("A", on_module_lost="fail")
    office.command("a1", "A")
    office.apply(ProviderLost, "r1")
    assert office.last["a1"].failure.name == office.last["A"].failure.name == "module_lost"


def test_a_prepared_place_ends_with_the_module_that_was_to_fill_it():
    office = Office()
    office.prepare("A")
    office.apply(ProviderLost, "r1", "me")
    assert "A" not in office.tree


@pytest.mark.bus
async def test_a_task_held_for_its_module_goes_on_when_that_is_back(
    user: Module, options: BusOptions
):
    class Keep(Command[str]):
        """Only its own module may do it."""

        on_module_lost = "hold"

    async def serve(module: Module, answer: str, gate: asyncio.Event) -> None:
        async def keep(_: Keep, __: TaskContext) -> str:
            await gate.wait()
            return answer

        module.serve(Keep, keep)

    gate = asyncio.Event()
    first = Module("keeper", options=options)
    await serve(first, "first", gate)
    async with first:
        await user.wait_for(Keep, timeout=10.0)
        task = await user.execute(Keep())
        await eventually(lambda: task.status.state == "active")
    gate.set()
    stranger = Module("stranger", options=options)
    await serve(stranger, "stranger", gate)
    async with stranger:
        await eventually(lambda: "keeper" in (task.status.waiting_for or ""))
        again = Module("keeper", options=options)
        await serve(again, "again", gate)
        async with again:
            assert await task.result(timeout=15.0) == "again"


class Fragile(Command[str]):
    """Fails with its module."""


class Again(Command[str]):
    """May be done by another."""

    on_module_lost = "resend"


@pytest.mark.bus
async def test_over_the_bus_a_task_fails_or_is_sent_again(options: BusOptions):
    async with (
        Module("user", options=options) as user,
        ScriptedModule("first", options=options) as first,
    ):
        holds = [first.holds(Fragile), first.holds(Again)]
        await user.wait_for(Fragile, Again, timeout=10.0)
        fragile = await user.execute(Fragile(), constraints=0)
        again = await user.execute(Again(), constraints=0)
        for hold in holds:
            await hold.reached()
        await first.vanish()
        with pytest.raises(TaskFailedError) as failed:
            await fragile.result(timeout=20.0)
        assert (failed.value.failure.name, failed.value.failure.module) == ("module_lost", "first")
        async with ScriptedModule("second", options=options) as second:
            second.answers(Again, "by the second")
            assert await again.result(timeout=20.0) == "by the second"
