"""Goals, facts and objects that come and go while a search runs."""

from __future__ import annotations

import pytest
from prodigy_office_runs import (
    FIGURE6,
    JHM,
    MITCHELL,
    PUBLISHED,
    at,
    figure6_search,
    metres,
    plain,
    run,
    shown,
)

from rogue.errands import Errand, Switches, example1998, figure6, figure9
from rogue.prodigy import (
    Execute,
    Finished,
    Literal,
    LiteralError,
    Poll,
    PollPoint,
    Rerooted,
    Search,
    SequenceError,
    Status,
    StepView,
    UnknownNameError,
)

PLAIN = plain(metres)
ALL = [PUBLISHED, figure9(metres), example1998(metres), PLAIN]
Changed = tuple[list[Literal], list[Literal]] | None


@pytest.mark.parametrize("switches", ALL)
@pytest.mark.parametrize("when", [1, 2, 3, 4])
def test_a_request_is_done_whenever_it_arrives(switches: Switches, when: int) -> None:
    steps: list[StepView] = []

    def outcome(search: Search, step: StepView) -> Changed:
        steps.append(step)
        if len(steps) == when:
            search.add_goal(switches.facts(JHM), switches.goal(JHM))
        return None

    search = run(figure6_search(switches), outcome=outcome)
    done = shown(search.executed_operators())
    assert "deliver-item r-5313 jhm deliverfax" in done
    assert "deliver-item r-5313 mitchell delivermail" in done
    assert search.goals == (switches.goal(MITCHELL), switches.goal(JHM))


@pytest.mark.parametrize("switches", ALL)
def test_a_request_can_be_dropped_before_its_item_is_taken(switches: Switches) -> None:
    steps: list[StepView] = []

    def outcome(search: Search, step: StepView) -> Changed:
        steps.append(step)
        if len(steps) == 1:
            search.add_goal(switches.facts(JHM), switches.goal(JHM))
            search.remove_goal(switches.goal(MITCHELL), switches.facts(MITCHELL))
        return None

    search = run(figure6_search(switches), outcome=outcome)
    done = shown(search.executed_operators())
    assert search.result is not None
    assert search.result.status is Status.SOLVED
    assert done[-1] == "deliver-item r-5313 jhm deliverfax"
    assert not any(step.startswith("deliver-item r-5313 mitchell") for step in done)


def test_a_dropped_errand_does_not_take_the_goto_of_another_with_it() -> None:
    def outcome(search: Search, step: StepView) -> Changed:
        if step.operator == "acquire-item" and "jhm" in step.args:
            search.remove_goal(PUBLISHED.goal(MITCHELL), PUBLISHED.facts(MITCHELL))
        elif len(search.executed_operators()) == 0:
            search.add_goal(PUBLISHED.facts(JHM), PUBLISHED.goal(JHM))
        return None

    search = run(figure6_search(example1998(metres)), outcome=outcome)
    assert shown(search.executed_operators())[-2:] == [
        "goto-deliver-loc jhm r-5313",
        "deliver-item r-5313 jhm deliverfax",
    ]


def test_dropping_the_only_goal_ends_the_search_without_another_step() -> None:
    def outcome(search: Search, _step: StepView) -> Changed:
        search.remove_goal(PLAIN.goal(MITCHELL), PLAIN.facts(MITCHELL))
        return None

    search = run(figure6_search(PLAIN), outcome=outcome)
    assert len(search.executed_operators()) == 1
    assert search.result is not None
    assert search.result.status is Status.SOLVED


def test_an_item_that_somebody_takes_from_the_tray_is_fetched_again() -> None:
    held = Literal("robot-has-item", ("mitchell", "delivermail"))

    def outcome(search: Search, _step: StepView) -> Changed:
        if len(search.executed_operators()) == 2:
            search.retract_facts(held)
        return None

    search = run(figure6_search(PLAIN), outcome=outcome)
    done = shown(search.executed_operators())
    assert done.count("acquire-item r-5303 mitchell delivermail") == 2
    assert done[-1] == "deliver-item r-5313 mitchell delivermail"


def test_what_another_brought_is_not_brought_again() -> None:
    def outcome(search: Search, _step: StepView) -> Changed:
        search.assert_facts(PLAIN.goal(MITCHELL))
        return None

    search = run(figure6_search(PLAIN), outcome=outcome)
    assert len(search.executed_operators()) == 1


def test_objects_can_come_with_a_request() -> None:
    newcomer = Errand("newell", "pickupcoffee", "r-5399", "r-5305")

    def outcome(search: Search, _step: StepView) -> Changed:
        if "newell" not in search.objects:
            with pytest.raises(UnknownNameError):
                search.add_goal(PLAIN.facts(newcomer), PLAIN.goal(newcomer))
            for name, kind in (("newell", "person"), ("pickupcoffee", "item"), ("r-5399", "room")):
                search.add_object(name, kind)
            search.add_goal(PLAIN.facts(newcomer), PLAIN.goal(newcomer))
        return None

    search = run(figure6_search(PLAIN), outcome=outcome)
    assert "deliver-item r-5305 newell pickupcoffee" in shown(search.executed_operators())


def test_goals_can_all_come_at_the_first_poll() -> None:
    switches = plain(lambda _a, _b: 1.0)
    rooms = ["r-1", "r-2", "r-3"]
    problem = switches.problem([], rooms=rooms, people=["ann"], items=["book"], at="r-1")
    search = Search(problem, switches.options, switches.rules)
    errand = Errand("ann", "book", "r-2", "r-3")
    added = False
    for event in search.events():
        if isinstance(event, Poll) and not added:
            search.add_goal(switches.facts(errand), switches.goal(errand))
            added = True
        elif isinstance(event, Execute):
            search.executed()
    assert len(search.nodes()) == 20
    assert shown(search.executed_operators())[-1] == "deliver-item r-3 ann book"


def test_without_goals_there_is_nothing_to_do() -> None:
    problem = PLAIN.problem([], rooms=[], people=[], items=[])
    search = run(Search(problem, PLAIN.options))
    assert search.result is not None
    assert search.result.status is Status.SOLVED
    assert search.result.plan == ()


def test_a_hopeless_goal_is_named() -> None:
    nowhere = Literal("has-item", ("jhm", "deliverfax"))

    def outcome(search: Search, _step: StepView) -> Changed:
        if not search.executed_operators():
            search.add_goal((), nowhere)
        return None

    search = run(figure6_search(PLAIN), outcome=outcome)
    assert search.result is not None
    assert search.result.status is Status.UNSOLVABLE
    assert search.result.hopeless == (nowhere,)
    assert "(has-item jhm deliverfax)" in search.result.reason


def test_what_was_executed_is_never_undone_by_backtracking() -> None:
    search = figure6_search(figure6())
    executed, rerooted = [], 0
    for event in search.events():
        if isinstance(event, Execute):
            executed.append(str(event.step))
            if len(executed) == 2:
                # The item falls off the tray, and nobody needs it any more: a dead end.
                search.retract_facts(Literal("needs-item", ("mitchell", "delivermail")))
            search.executed()
        rerooted += isinstance(event, Rerooted)
    assert rerooted == 1
    assert [str(step) for step in search.executed_operators()] == executed
    assert search.result is not None
    assert search.result.status is Status.UNSOLVABLE


def test_a_change_waits_for_the_poll_at_the_end_of_the_cycle() -> None:
    search = figure6_search(figure6())
    assert search.options.poll is PollPoint.END_OF_CYCLE
    for event in search.events():
        if isinstance(event, Execute):
            search.add_goal(PUBLISHED.facts(JHM), PUBLISHED.goal(JHM))
            assert PUBLISHED.goal(JHM) not in search.goals
            search.executed()
            assert PUBLISHED.goal(JHM) not in search.goals
            break
    assert isinstance(next(e for e in search.events() if isinstance(e, Poll)), Poll)
    assert PUBLISHED.goal(JHM) in search.goals


def test_a_search_can_be_stopped_even_while_an_action_executes() -> None:
    search = figure6_search(figure6())
    for event in search.events():
        if isinstance(event, Execute):
            with pytest.raises(SequenceError):
                search.step()
            search.stop("the robot is on fire")
        elif isinstance(event, Finished):
            assert event.result.status is Status.STOPPED
            assert event.result.reason == "the robot is on fire"
    assert search.step() is None


def test_literals_given_by_a_program_are_checked() -> None:
    search = Search(FIGURE6)
    with pytest.raises(UnknownNameError, match="did you mean robot-in-room"):
        search.assert_facts(Literal("robot-in-rom", ("r-5301",)))
    with pytest.raises(UnknownNameError, match="did you mean"):
        search.assert_facts(at("r-5399x"))
    with pytest.raises(LiteralError, match="1 arguments"):
        search.assert_facts(Literal("robot-in-room", ("r-5301", "r-5303")))
    with pytest.raises(UnknownNameError, match="no goal named"):
        search.remove_goal(PUBLISHED.goal(JHM))
    with pytest.raises(SequenceError, match="no action is executing"):
        search.executed()
