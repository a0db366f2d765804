"""Processes are killed at random while tasks run: the short form of ``chaos_run.py``."""

from __future__ import annotations

from collections import Counter

import pytest
from chaos_plan import make_plan
from chaos_run import run_chaos, summary
from chaos_verdict import broken_promises


def test_a_seed_gives_the_same_plan_again():
    sizes = {"tasks": 50, "kills": 12, "modules": 10}
    assert make_plan(seed=7, **sizes) == make_plan(seed=7, **sizes)
    assert make_plan(seed=7, **sizes) != make_plan(seed=8, **sizes)


def test_router_and_central_are_among_the_victims():
    plan = make_plan(seed=7, tasks=50, kills=12, modules=10)
    victims = Counter(kill.victim for kill in plan.kills)
    assert victims["router"] == victims["central"] == 2
    assert victims.total() == 12


@pytest.mark.bus
@pytest.mark.process
@pytest.mark.timeout(240)
@pytest.mark.parametrize("seed", [1])
async def test_every_acknowledged_task_ends_exactly_once(seed, tmp_path):
    record = await run_chaos(make_plan(seed=seed, tasks=60, kills=6, modules=5), tmp_path)
    assert broken_promises(record) == [], f"seed {seed}\n{summary(record)}"
    assert len(record.acknowledged) == 60
    assert len(record.struck) == 6
    victims = {struck.victim for struck in record.struck}
    assert {"router", "central"} < victims
