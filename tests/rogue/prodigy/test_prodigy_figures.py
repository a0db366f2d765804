"""One engine and one domain print every published trace; only the switches differ."""

from __future__ import annotations

from prodigy_office_runs import (
    JHM,
    PUBLISHED,
    arrives_during_first_step,
    figure6_search,
    metres,
    run,
    shown,
    wrong_room_first,
)
from prodigy_published_traces import EXAMPLE1998, FIGURE6, FIGURE9

from rogue.errands import example1998, figure6, figure9
from rogue.prodigy import Announced, Event, Execute, Executed, Search, Status

HAS_JHM = "(has-item jhm deliverfax)"
TO_PICKUP = "goto-pickup-loc mitchell r-5303"
TO_DELIVER = "goto-deliver-loc mitchell r-5313"
ACQUIRE = "acquire-item r-5303 mitchell delivermail"
TO_JHM = "goto-pickup-loc jhm r-5311"


def text(search: Search) -> str:
    return "\n".join(search.trace) + "\n"


def test_figure6_is_printed_byte_for_byte() -> None:
    search = run(figure6_search(figure6()))
    assert text(search) == FIGURE6
    assert len(search.nodes()) == 21


def test_figure9_is_printed_byte_for_byte() -> None:
    search = run(figure6_search(figure9(metres)), outcome=arrives_during_first_step(JHM))
    assert text(search) == FIGURE9
    assert shown(search.executed_operators()) == [
        TO_PICKUP,
        ACQUIRE,
        TO_JHM,
        "acquire-item r-5311 jhm deliverfax",
        TO_DELIVER,
        "deliver-item r-5313 jhm deliverfax",
        "deliver-item r-5313 mitchell delivermail",
    ]


def test_figure9_without_the_nearest_room_rule_drives_to_the_far_room_first() -> None:
    search = run(figure6_search(figure6()), outcome=arrives_during_first_step(JHM))
    assert (len(search.nodes()), len(search.executed_operators())) == (38, 8)


def test_the_1998_example_is_printed_byte_for_byte() -> None:
    search = run(figure6_search(example1998(metres)), outcome=arrives_during_first_step(JHM))
    assert text(search) == EXAMPLE1998


def lists(search: Search) -> tuple[list[str], list[str], list[str]]:
    pending = [str(goal) for goal in search.pending_goals()]
    return pending, shown(search.applicable_operators()), shown(search.executed_operators())


def test_the_1998_example_has_the_lists_of_the_paper_at_each_step() -> None:
    search = figure6_search(example1998(metres))
    seen = {}
    for event in search.events():
        name = _moment(event)
        if name:
            seen[name] = lists(search)
        if isinstance(event, Execute):
            if event.node.number == 17:
                search.add_goal(PUBLISHED.facts(JHM), PUBLISHED.goal(JHM))
                seen["request"] = lists(search)
            search.executed()
    assert seen["announced 4"] == (["(has-item mitchell delivermail)"], [], [])
    wanted = ["(robot-has-item mitchell delivermail)", "(robot-in-room r-5313)"]
    assert seen["announced 7"] == (wanted, [], [])
    assert seen["announced 16"] == ([], [TO_DELIVER, TO_PICKUP], [])
    assert seen["execute 17"] == ([], [TO_DELIVER], [])
    assert seen["request"] == ([HAS_JHM], [TO_DELIVER], [])
    assert seen["executed 17"] == ([HAS_JHM], [TO_DELIVER, ACQUIRE], [TO_PICKUP])
    assert seen["announced 26"] == ([], [TO_DELIVER, ACQUIRE, TO_JHM], [TO_PICKUP])
    assert seen["executed 27"] == ([], [TO_DELIVER, TO_JHM], [TO_PICKUP, ACQUIRE])
    acquire_jhm = "acquire-item r-5311 jhm deliverfax"
    assert seen["executed 28"] == ([], [TO_DELIVER, acquire_jhm], [TO_PICKUP, ACQUIRE, TO_JHM])


def _moment(event: Event) -> str:
    if isinstance(event, Announced | Execute | Executed):
        return f"{type(event).__name__.lower()} {event.node.number}"
    return ""


def test_a_failed_navigation_is_retried_with_the_nearest_room_rule() -> None:
    search = run(figure6_search(figure9(metres)), outcome=wrong_room_first("r-5305"))
    lines = text(search).splitlines()
    assert lines[11] == (
        " 17       n18 <GOTO-PICKUP-LOC MITCHELL R-5303> warning: desired goal was not achieved"
    )
    assert lines[12:] == [
        " 18       n19 (robot-in-room r-5303)",
        " 20       n21 <goto-pickup-loc mitchell r-5303>",
        " 21       n22 <GOTO-PICKUP-LOC MITCHELL R-5303>",
        " 22     n23 <ACQUIRE-ITEM R-5303 MITCHELL DELIVERMAIL>",
        " 23     n24 <GOTO-DELIVER-LOC MITCHELL R-5313>",
        " 23   n25 <DELIVER-ITEM R-5313 MITCHELL DELIVERMAIL>",
        "Achieved top-level goals.",
    ]
    assert len(search.executed_operators()) == 5


def test_a_failed_navigation_with_the_default_choice_wastes_a_trip() -> None:
    search = run(figure6_search(figure6()), outcome=wrong_room_first("r-5305"))
    assert (len(search.nodes()), len(search.executed_operators())) == (30, 6)
    assert shown(search.executed_operators())[1] == TO_DELIVER


def test_the_last_operator_that_fails_is_not_the_end() -> None:
    def not_handed_over(search: Search, step: object) -> object:
        first = "deliver-item" in str(step).lower() and len(search.executed_operators()) == 3
        return ([], []) if first else None

    search = run(figure6_search(figure6()), outcome=not_handed_over)  # type: ignore[arg-type]
    assert search.result is not None
    assert search.result.status is Status.SOLVED
    delivered = [s for s in shown(search.executed_operators()) if s.startswith("deliver-item")]
    assert len(delivered) == 2
    assert any(line.endswith("desired goal was not achieved") for line in search.trace)
