"""Shared variables (tca.md 3.12): set, get, swap and watch, held by central."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import sys
from contextlib import asynccontextmanager

import pytest
import zenoh
from hypothesis import given, settings
from hypothesis import strategies as st
from mortal_router import MortalRouter
from pydantic import BaseModel

from tca_bus import (
    ConfigError,
    InvalidMessageError,
    Module,
    NeverSetError,
    RefusedError,
    Variable,
    VariableChangedError,
)
from tca_bus._faults import decode_error, encode_error
from tca_bus._joining import client_config
from tca_bus._variables import MOST_VALUE_BYTES, SetVariable, VariableState, VariableTable
from tca_bus.testing import bus, central, eventually


class Place(BaseModel):
    x: float
    y: float


BATTERY = Variable("battery", float)
PLACE = Variable("place", Place)


def order(value, change, **more):
    return SetVariable(name="battery", value=value, change=change, **more)


def test_a_change_gives_what_was_and_what_is():
    table = VariableTable()
    first = table.apply(order(1.0, "a"), writer="x", now=10.0)
    second = table.apply(order(2.0, "b"), writer="y", now=11.0)
    assert (first.before, first.after.sequence) == (None, 1)
    assert second.before == first.after
    assert (second.after.value, second.after.writer, second.after.sequence) == (2.0, "y", 2)
    assert (second.after.created, second.after.changed) == (10.0, 11.0)


def test_a_change_that_is_sent_again_is_made_once():
    table = VariableTable()
    first = table.apply(order(1.0, "a"), writer="x", now=10.0)
    table.apply(order(2.0, "b"), writer="x", now=11.0)
    assert table.apply(order(1.0, "a"), writer="x", now=12.0) == first
    assert table.get("battery").value == 2.0


def test_compare_and_set_names_both_numbers():
    table = VariableTable()
    table.apply(order(1.0, "a", expected=0), writer="x", now=10.0)
    with pytest.raises(VariableChangedError, match=r"expected sequence 0 \(never set\), found 1"):
        table.apply(order(2.0, "b", expected=0), writer="x", now=10.0)
    table.apply(order(2.0, "c", expected=1), writer="x", now=10.0)


def test_a_value_of_another_type_is_refused_until_the_variable_is_redefined():
    table = VariableTable()
    table.apply(order(1.0, "a", value_schema=BATTERY.schema()), writer="x", now=10.0)
    with pytest.raises(InvalidMessageError, match="value: expected number, got 'full'"):
        table.apply(order("full", "b"), writer="x", now=10.0)
    with pytest.raises(InvalidMessageError, match="expected number"):
        table.apply(order("full", "c", value_schema={"type": "string"}), writer="x", now=10.0)
    table.apply(order("full", "d", redefine=True), writer="x", now=10.0)
    assert table.get("battery").value == "full"


def test_what_is_too_big_or_one_too_many_is_refused(monkeypatch):
    monkeypatch.setattr("tca_bus._variables.MOST_VARIABLES", 1)
    table = VariableTable()
    with pytest.raises(InvalidMessageError, match=f"at most {MOST_VALUE_BYTES} bytes"):
        table.apply(order("x" * MOST_VALUE_BYTES, "a"), writer="x", now=10.0)
    table.apply(order(1, "b"), writer="x", now=10.0)
    with pytest.raises(RefusedError, match="there are 1 already"):
        table.apply(SetVariable(name="other", value=1, change="c"), writer="x", now=10.0)


def test_a_schema_without_end_is_no_endless_loop():
    endless = {"$ref": "#/$defs/a", "$defs": {"a": {"anyOf": [{"$ref": "#/$defs/a"}]}}}
    table = VariableTable()
    table.apply(order(1, "a", value_schema=endless), writer="x", now=10.0)
    with pytest.raises(InvalidMessageError, match="refers to itself"):
        table.apply(order(2, "b"), writer="x", now=10.0)


@settings(deadline=None)
@given(st.lists(st.tuples(st.sampled_from("abcd"), st.integers()), max_size=30))
def test_the_sequence_counts_the_changes_that_were_made(changes):
    table = VariableTable()
    values = {}
    for change, value in changes:
        values.setdefault(change, value)
        table.apply(order(value, change), writer="x", now=1.0)
        assert table.made(change).after.value == values[change]
    if changes:
        assert table.get("battery").sequence == len(values)


def test_a_state_of_a_younger_variable_is_newer_whatever_its_number():
    def state(created, sequence):
        return VariableState(
            name="a", value=0, sequence=sequence, writer="x", created=created, changed=created
        )

    assert state(1.0, 2).is_newer_than(state(1.0, 1))
    assert not state(1.0, 1).is_newer_than(state(1.0, 1))
    assert state(2.0, 1).is_newer_than(state(1.0, 9))
    assert state(1.0, 1).is_newer_than(None)


@pytest.mark.parametrize("error", [NeverSetError("a", ["ab"]), VariableChangedError("a", 0, 3)])
def test_the_errors_cross_the_bus_as_themselves(error):
    crossed = decode_error(encode_error(error, message="m", module="x"), message="m")
    assert type(crossed) is type(error)
    assert str(crossed) == str(error)


def test_a_variable_has_a_name_that_fits_a_key():
    with pytest.raises(ConfigError, match="variable name is 'a/b'"):
        Variable("a/b", int)


@asynccontextmanager
async def office(data=None):
    async with (
        bus() as options,
        central(options, data=data),
        Module("me", options=options) as me,
    ):
        await me.wait_for(SetVariable, timeout=10.0)
        yield options, me


@pytest.mark.bus
async def test_set_get_swap_and_compare_and_set():
    async with office() as (_, me):
        with pytest.raises(NeverSetError, match="'battery' was never set"):
            await me.get(BATTERY)
        assert await me.set(BATTERY, 12.5) == 1
        assert await me.get(BATTERY) == 12.5
        assert await me.swap(BATTERY, 12.0) == 12.5
        assert await me.swap(PLACE, Place(x=1, y=2)) is None
        assert await me.get(PLACE) == Place(x=1, y=2)
        reading = await me.read(BATTERY)
        assert (reading.value, reading.sequence, reading.writer) == (12.0, 2, "me")
        assert await me.set(BATTERY, 11.0, expected=2) == 3
        with pytest.raises(VariableChangedError):
            await me.set(BATTERY, 10.0, expected=2)
        assert [state.name for state in await me.variables()] == ["battery", "place"]


@pytest.mark.bus
async def test_a_wrong_type_is_told_with_field_and_value():
    async with office() as (_, me):
        with pytest.raises(InvalidMessageError, match=r"variable battery.*number.*'full'"):
            await me.set(BATTERY, "full")
        await me.set(BATTERY, 12.0)
        with pytest.raises(InvalidMessageError, match=r"a valid string, got 12\.0"):
            await me.get(Variable("battery", str))
        with pytest.raises(InvalidMessageError, match="expected number, got 'full'"):
            await me.set(Variable("battery", str), "full")


@pytest.mark.bus
async def test_of_many_that_swap_at_once_each_value_comes_out_once():
    async with office() as (options, me), Module("other", options=options) as other:
        token = Variable("token", int)
        await me.set(token, -1)
        swaps = [(me, other)[n % 2].swap(token, n) for n in range(40)]
        came_out = await asyncio.gather(*swaps)
        assert sorted([*came_out, await me.get(token)]) == list(range(-1, 40))


@pytest.mark.bus
async def test_a_late_watcher_has_the_value_at_once_and_then_every_latest_one():
    async with office() as (options, me), Module("late", options=options) as late:
        await me.set(BATTERY, 12.5)
        async with late.watch(BATTERY) as changes:
            assert (await anext(changes)).value == 12.5
            for value in (12.4, 12.3, 12.2):
                await me.set(BATTERY, value)
            seen = await anext(changes)
            while seen.value != 12.2:
                seen = await anext(changes)
            assert seen.sequence == 4
        assert [one async for one in changes] == []


@pytest.mark.bus
async def test_a_watcher_of_another_type_is_told_and_goes_on():
    async with office() as (_, me):
        mood = Variable("mood", str)
        async with me.watch(Variable("mood", int)) as changes:
            await me.set(mood, "fine")
            with pytest.raises(InvalidMessageError, match="variable mood"):
                await anext(changes)
            await me.set(Variable("mood", int), 3, redefine=True)
            assert (await anext(changes)).value == 3


def read(sample):
    return json.loads(sample.payload.to_bytes())


@pytest.mark.bus
async def test_any_zenoh_tool_reads_and_hears_a_variable():
    async with office() as (options, me):
        stranger = await asyncio.to_thread(zenoh.open, client_config(options))
        try:
            heard: list[dict] = []
            key = f"{options.realm}/variable/battery"
            stranger.declare_subscriber(
                key, lambda s: heard.append(json.loads(s.payload.to_bytes()))
            )
            await me.set(BATTERY, 12.5)

            def get(selector):
                return [read(reply.ok) for reply in stranger.get(selector)]

            (state,) = await asyncio.to_thread(get, f"{options.realm}/variable/*")
            assert (state["name"], state["value"], state["sequence"]) == ("battery", 12.5, 1)

            async def hears_the_next():
                await me.set(BATTERY, 12.0)
                return heard and heard[-1]["value"] == 12.0

            await eventually(hears_the_next)
            assert await asyncio.to_thread(get, f"{options.realm}/variable/other") == []
        finally:
            await asyncio.to_thread(stranger.close)


async def start_central(options, data):
    return await asyncio.create_subprocess_exec(
        sys.executable,
        *("-m", "tca_bus", "central", "--connect", options.connect, "--realm", options.realm),
        *("--data", str(data), "--log-level", "error"),
    )


async def end(process):
    if process.returncode is None:
        process.kill()
    await process.wait()


@pytest.mark.bus
@pytest.mark.process
async def test_what_was_acknowledged_survives_a_killed_central(tmp_path):
    async with bus() as options, Module("me", options=options) as me:
        first = await start_central(options, tmp_path)
        second = None
        try:
            await me.wait_for(SetVariable, timeout=20.0)
            async with me.watch(BATTERY) as changes:
                for number in range(20):
                    await me.set(BATTERY, float(number))
                os.kill(first.pid, signal.SIGKILL)
                await first.wait()
                second = await start_central(options, tmp_path)
                assert await me.swap(BATTERY, 50.0, timeout=30.0) == 19.0
                assert (await me.read(BATTERY)).sequence == 21
                while (await anext(changes)).value != 50.0:
                    pass
        finally:
            for process in (first, second):
                if process is not None:
                    await end(process)


@pytest.mark.bus
async def test_what_is_set_while_the_router_is_away_reaches_the_watchers():
    async with (
        MortalRouter() as router,
        central(router.options),
        Module("me", options=router.options) as me,
    ):
        await me.wait_for(SetVariable, timeout=10.0)
        await me.set(BATTERY, 1.0)
        async with me.watch(BATTERY) as changes:
            assert (await anext(changes)).value == 1.0
            await router.die()
            await eventually(lambda: not me.is_connected)
            setting = asyncio.create_task(me.set(BATTERY, 2.0, timeout=30.0))
            await router.rise()
            assert (await anext(changes)).value == 2.0
            assert await setting == 2
