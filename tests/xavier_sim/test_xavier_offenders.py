"""Drivers whose commands cannot be used are named, each of them, and not at every tick."""

from __future__ import annotations

import pytest
from test_xavier_bus import StandIn, robot

from tca_bus import Module
from tca_bus.testing import bus, eventually
from xavier_sim.messages import Drive
from xavier_sim.running._offenders import WORD_SECONDS, Offenders


def test_who_offends_is_named_until_it_is_sound_and_once_a_minute_at_most():
    offenders = Offenders()
    assert [offenders.offend("navigate", float(wall)) for wall in range(3)] == [True, False, False]
    assert offenders.offend("other", 3.0)
    assert not offenders.offend("navigate", 10 * WORD_SECONDS)
    offenders.clear("navigate")
    assert offenders.offend("navigate", 10 * WORD_SECONDS)
    offenders.clear("navigate")
    assert not offenders.offend("navigate", 11 * WORD_SECONDS - 1.0)
    assert offenders.offend("navigate", 11 * WORD_SECONDS)
    offenders.forget("navigate")
    assert offenders.offend("navigate", 11 * WORD_SECONDS + 1.0)


@pytest.mark.bus
async def test_each_driver_whose_commands_are_ignored_is_named_once(caplog):
    def named(name):
        return sum(f"command of {name} for tick 0 ignored" in text for text in caplog.messages)

    async with bus() as options, robot(options) as state:
        driver = StandIn(options, ticks=60)
        answer = driver.answer

        async def late(sensors):
            await answer(sensors)
            for module in (driver.module, other):
                old = Drive(tick=0, speed=0.5, turn_rate=0.0, busy=True)
                await module.inform(old)

        async with driver.module, Module("other", options=options) as other:
            await eventually(lambda: state.tick == 60)
            driver.ticks, driver.answer = 80, late
            await late(driver.seen[-1])
            await eventually(lambda: state.tick == 80)
            await eventually(lambda: named("other"))
    assert (named("navigate"), named("other")) == (1, 1)
