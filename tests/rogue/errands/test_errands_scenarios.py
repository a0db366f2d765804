"""The papers' scenarios with many errands, on the working domain."""

from __future__ import annotations

import random
from math import inf

import pytest
from errands_play import Changed, Play, corridor
from hypothesis import given, settings
from hypothesis import strategies as st

from rogue.errands import Errand, OpenErrand, best_tour
from rogue.prodigy import Choice, Literal, StepView

MAIL = Errand("mitchell", "delivermail", "r-5301", "r-5315")
PARCEL = Errand("jhm", "parcel", "r-5409", "r-4320")
ROOMS = ["r-5301", "r-5303", "r-5305", "r-5311", "r-5313", "r-5315", "r-5409", "r-4320"]
MAIL_STEPS = [
    "goto-pickup-loc mitchell r-5301",
    "acquire-item r-5301 mitchell delivermail",
    "goto-deliver-loc mitchell r-5315",
    "deliver-item r-5315 mitchell delivermail",
]
PARCEL_STEPS = [
    "goto-pickup-loc jhm r-5409",
    "acquire-item r-5409 jhm parcel",
    "goto-deliver-loc jhm r-4320",
    "deliver-item r-4320 jhm parcel",
]


def interrupted(step: int, outcome: Changed = None) -> Play:
    """The parcel, which is more important, is asked for while a step of the mail goes on."""
    play = Play()

    def arrive() -> Changed:
        play.arrive(play.claim(PARCEL, 9.0))
        return outcome

    play.at_step[step] = arrive
    play.begin([play.claim(MAIL, 2.0)], ROOMS, at="r-5305")
    return play


def test_a_suspended_errand_goes_on_where_it_was():
    """[AR] node 15, *normal*: what still holds is not done again."""
    play = interrupted(2)
    assert play.run() == [*MAIL_STEPS[:2], *PARCEL_STEPS, *MAIL_STEPS[2:]]


def test_what_does_not_hold_any_more_is_done_again():
    """[AR] node 15, *undone*: the robot left before it was given the mail."""
    play = interrupted(2, ([], []))
    assert play.run() == [*MAIL_STEPS[:2], *PARCEL_STEPS, *MAIL_STEPS]


def test_an_errand_that_is_put_off_is_named_by_the_rule():
    play = interrupted(2)
    play.run()
    put_off = [
        fired.effect
        for decided in play.search.decisions
        if decided.choice is Choice.APPLIED_OP
        for fired in decided.rules
        if fired.rule == "put-off-for-top-priority"
    ]
    assert ("<goto-deliver-loc mitchell r-5315>",) in put_off


@settings(max_examples=15, deadline=None)
@given(st.lists(st.permutations(ROOMS[:6]), min_size=1, max_size=3))
def test_the_robot_goes_the_way_of_the_best_tour(ends: list[list[str]]):
    play = Play()
    things = [("mitchell", "delivermail"), ("jhm", "deliverfax"), ("newell", "parcel")]
    errands = [
        Errand(*thing, rooms[0], rooms[1]) for thing, rooms in zip(things, ends, strict=False)
    ]
    play.begin(errands, ROOMS)
    here, metres = "r-5301", 0.0
    for step in play.run():
        if step.startswith("goto"):
            metres, here = metres + corridor(here, step.split()[-1]), step.split()[-1]
    tour = best_tour(
        [OpenErrand(key=e.item, pickup=e.pickup, deliver=e.deliver) for e in errands],
        start="r-5301",
        travel=play.agenda.travel,
    )
    assert metres == pytest.approx(tour.metres)


def test_two_deliveries_to_one_room_share_one_way():
    """Figure 10: plans that are compatible are merged."""
    play = Play()
    fax = Errand("jhm", "deliverfax", "r-5311", "r-5313")
    mail = Errand("mitchell", "delivermail", "r-5303", "r-5313")
    play.begin([mail, fax], ROOMS)
    done = play.run()
    assert [step for step in done if "r-5313" in step] == [
        "goto-deliver-loc mitchell r-5313",
        *sorted((s for s in done if s.startswith("deliver-item")), key=done.index),
    ]
    assert len(play.search.nodes()) <= 4 + 16 * 2 - 4


def test_a_plan_that_is_partly_executed_is_merged_with_a_new_one():
    """Figure 11: what was acquired is not acquired again."""
    play = Play()
    mail = play.claim(Errand("mitchell", "delivermail", "r-5303", "r-5313"), 2.0)
    fax = play.claim(Errand("jhm", "deliverfax", "r-5311", "r-5313"), 8.0)
    play.at_step[2] = lambda: play.arrive(fax)
    play.begin([mail], ROOMS)
    assert play.run() == [
        "goto-pickup-loc mitchell r-5303",
        "acquire-item r-5303 mitchell delivermail",
        "goto-pickup-loc jhm r-5311",
        "acquire-item r-5311 jhm deliverfax",
        "goto-deliver-loc mitchell r-5313",
        "deliver-item r-5313 jhm deliverfax",
        "deliver-item r-5313 mitchell delivermail",
    ]


def test_goals_are_planned_by_priority_and_executed_by_the_way():
    """The priority paradox of [AR], steps 7 and 8: the two are decisions of their own."""
    play = Play()
    mail = play.claim(Errand("mitchell", "delivermail", "r-5303", "r-5313"), 2.0)
    fax = play.claim(Errand("jhm", "deliverfax", "r-5311", "r-5313"), 8.0)
    play.at_step[1] = lambda: play.arrive(fax)
    play.begin([mail], ROOMS)
    done = play.run()
    arrived = next(n.number for n in play.search.nodes() if n.executed)
    choices = [d for d in play.search.decisions if d.at >= arrived]
    assert choices[0].choice is Choice.GOAL
    assert choices[0].chosen == "(has-item jhm deliverfax)"
    assert choices[0].reason == "select-top-priority-and-compatible-goals"
    assert done[1] == "acquire-item r-5303 mitchell delivermail"


def test_after_a_failed_navigation_the_way_goes_on_from_where_the_robot_is():
    """Section 5.4: three tries are the navigator's; the planner goes on from the fourth."""
    play = Play()
    mail = Errand("mitchell", "delivermail", "r-5303", "r-5313")
    here, there = Literal("robot-in-room", ("r-5305",)), Literal("robot-in-room", ("r-5301",))
    play.at_step[1] = lambda: ([here], [there])
    play.begin([mail], ROOMS)
    assert play.run()[:3] == [
        "goto-pickup-loc mitchell r-5303",
        "goto-pickup-loc mitchell r-5303",
        "acquire-item r-5303 mitchell delivermail",
    ]
    assert len(play.search.nodes()) == 20 + 4
    assert any(line.endswith("desired goal was not achieved") for line in play.search.trace)


def test_what_is_on_the_way_of_an_urgent_errand_is_not_put_off():
    play = Play()
    far = play.claim(Errand("jhm", "parcel", "r-5301", "r-5315"), 9.0)
    between = play.claim(Errand("mitchell", "delivermail", "r-5305", "r-5311"), 0.0)
    play.begin([far, between], ROOMS, at="r-5301")
    done = play.run()
    taken, brought = "acquire-item r-5305 mitchell delivermail", "deliver-item r-5315 jhm parcel"
    assert done.index(taken) < done.index(brought)


def test_with_no_detour_allowed_an_urgent_errand_is_alone():
    play = Play(nearby=1.0)
    far = play.claim(Errand("jhm", "parcel", "r-5313", "r-5315"), 9.0)
    behind = play.claim(Errand("mitchell", "delivermail", "r-5303", "r-5301"), 0.0)
    play.begin([behind, far], ROOMS, at="r-5305")
    assert play.run()[3] == "deliver-item r-5315 jhm parcel"


def test_an_errand_that_comes_near_its_deadline_overtakes():
    play = Play(nearby=1.0)
    soon = play.claim(Errand("newell", "deliverfax", "r-5313", "r-5315"), 1.0, deadline=4000.0)
    other = play.claim(Errand("mitchell", "delivermail", "r-5303", "r-5301"), 1.0)
    play.begin([other, soon], ROOMS, at="r-5303")

    def time_passes() -> None:
        play.now = 3900.0

    play.at_step[1] = time_passes
    done = play.run()
    assert done[0] == "acquire-item r-5303 mitchell delivermail"
    assert done.index("deliver-item r-5315 newell deliverfax") < done.index(
        "deliver-item r-5301 mitchell delivermail"
    )


def test_the_robot_turns_back_with_nothing_done_where_priorities_change_twice():
    play = Play()

    def rank(mail: float, parcel: float) -> None:
        play.claim(MAIL, mail)
        play.claim(PARCEL, parcel)

    rank(mail=20.0, parcel=2.0)
    play.at_step = {1: lambda: rank(mail=2.0, parcel=20.0), 2: lambda: rank(mail=20.0, parcel=2.0)}
    play.begin([MAIL, PARCEL], ROOMS, at="r-5305")
    assert play.run() == [MAIL_STEPS[0], PARCEL_STEPS[0], *MAIL_STEPS, *PARCEL_STEPS]


ERRANDS = st.lists(
    st.builds(
        Errand,
        st.sampled_from(["mitchell", "jhm", "newell"]),
        st.sampled_from(["delivermail", "deliverfax", "parcel"]),
        st.sampled_from(ROOMS[:4]),
        st.sampled_from(ROOMS[4:]),
    ),
    min_size=2,
    max_size=9,
    unique_by=lambda errand: (errand.user, errand.item),
)


def whereto(step: StepView) -> str:
    """Where a drive leads, whoever it is for; any other step in full."""
    return str(step.args[1] if step.operator.startswith("goto") else step)


@settings(max_examples=15)
@given(errands=ERRANDS, places=st.sampled_from([None, 2, 4]), chance=st.randoms())
def test_a_search_begun_anew_at_any_step_goes_on_as_the_one_that_runs(
    errands: list[Errand], places: int | None, chance: random.Random
):
    """What a planner that was killed has on disk is enough for it to go on as it would have."""
    running = Play(places=places)
    for errand in errands:
        deadline = chance.choice([inf, chance.uniform(200.0, 2500.0)])
        running.claim(errand, chance.randint(0, 9), deadline, posted=chance.random())
    running.begin(errands, ROOMS)
    here, tray, left = "r-5301", list[tuple[str, str]](), list(errands)
    while step := running.next_step():
        fresh = Play(places=places, agenda=running.agenda)
        fresh.begin(reversed(left), ROOMS, at=here, carried=tray)
        other = fresh.next_step()
        assert other is not None
        assert whereto(other) == whereto(step)
        thing = (str(step.args[1]), str(step.args[-1]))
        match step.operator:
            case "acquire-item":
                tray.append(thing)
            case "deliver-item":
                tray.remove(thing)
                left = [errand for errand in left if (errand.user, errand.item) != thing]
            case _:
                here = str(step.args[1])
        running.now += chance.uniform(5.0, 80.0)
        running.search.executed()
    assert not left
