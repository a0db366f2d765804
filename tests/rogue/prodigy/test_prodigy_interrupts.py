"""Handlers, signals, and who stopped a search."""

from __future__ import annotations

import pytest
from prodigy_office_runs import JHM, MITCHELL, PUBLISHED, figure6_search, metres, run, shown

from rogue.errands import example1998, figure6
from rogue.prodigy import (
    Execute,
    FunctionError,
    Poll,
    Search,
    Status,
    Stop,
    UnknownNameError,
)


def test_always_handlers_run_once_a_cycle_before_the_poll() -> None:
    search = figure6_search(figure6())
    order: list[str] = []
    search.define_handler("always", lambda _s, _d: order.append("handler"))
    for event in search.events():
        if isinstance(event, Poll):
            order.append("poll")
        elif isinstance(event, Execute):
            search.executed()
    assert order == ["handler", "poll"] * (len(order) // 2)
    assert len(order) > 20


def test_a_signal_brings_its_data_to_its_handlers_at_the_next_poll() -> None:
    search = figure6_search(example1998(metres))
    came: list[object] = []

    def request(it: Search, data: object) -> None:
        came.append(data)
        it.add_goal(PUBLISHED.facts(JHM), PUBLISHED.goal(JHM))

    search.define_handler("request", request)
    for event in search.events():
        if isinstance(event, Execute):
            if not search.executed_operators():
                search.signal("request", "of jhm")
                assert came == []
            search.executed()
    assert came == ["of jhm"]
    assert "deliver-item r-5313 jhm deliverfax" in shown(search.executed_operators())
    assert (
        next(str(node) for node in search.nodes() if node.literal == PUBLISHED.goal(JHM)) == "n18"
    )


def test_a_handler_stops_the_search_and_is_named() -> None:
    search = figure6_search(figure6())
    search.define_handler(
        "battery", lambda _s, data: Stop(f"the battery is at {data} %", by="battery monitor")
    )
    search.signal("battery", 4)
    run(search)
    assert search.result is not None
    assert search.result.status is Status.STOPPED
    assert search.result.stop == Stop("the battery is at 4 %", by="battery monitor")
    assert search.result.reason == "the battery is at 4 %"
    assert search.executed_operators() == ()


def test_the_search_signals_its_start_and_its_achievement() -> None:
    search = figure6_search(figure6())
    signalled: list[str] = []
    search.define_handler("start-run", lambda _s, _d: signalled.append("start-run"))

    def achieved(it: Search, _data: object) -> None:
        signalled.append("achieve")
        if PUBLISHED.goal(JHM) not in it.goals:
            it.add_goal(PUBLISHED.facts(JHM), PUBLISHED.goal(JHM))

    search.define_handler("achieve", achieved)
    run(search)
    assert signalled == ["start-run", "achieve", "achieve"]
    assert search.goals == (PUBLISHED.goal(MITCHELL), PUBLISHED.goal(JHM))
    assert shown(search.executed_operators())[-1] == "deliver-item r-5313 jhm deliverfax"


def test_bad_handlers_and_signals_are_told() -> None:
    search = figure6_search(figure6())
    with pytest.raises(UnknownNameError, match="did you mean achieve"):
        search.signal("achive")
    search.define_handler("always", lambda _s, _d: "stop")  # type: ignore[arg-type, return-value]
    with pytest.raises(FunctionError, match="gave 'stop', expected a Stop"):
        run(search)
    other = figure6_search(figure6())
    other.define_handler("start-run", lambda _s, _d: other.signal("nonsense"))
    with pytest.raises(FunctionError, match="handler of start-run"):
        run(other)


def test_too_many_signals_are_refused() -> None:
    search = figure6_search(figure6())
    search.define_handler("tick", lambda _s, _d: None)
    for at in range(10_000):
        search.signal("tick", at)
    with pytest.raises(OverflowError):
        search.signal("tick")
