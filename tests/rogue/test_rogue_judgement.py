"""What follows from a step that came to nothing."""

from __future__ import annotations

import pytest
from rogue_fakes import make_request

from rogue.execution import Case, Patience, Verdict, judge
from rogue.memory import Facts, PastStep, Step
from rogue.messages import Closing, DeliveryRequest, RequestState
from rogue.outcomes import StepOutcome, Trouble
from rogue.times import show_time

MAIL = ("mitchell", "delivermail")
PATIENCE = Patience(later=600.0, returns=2)
ACQUIRE = ("acquire-item", ("r-5303", *MAIL))
DELIVER = ("deliver-item", ("r-5313", *MAIL))
RETURN = ("return-item", ("r-5303", *MAIL))
GOTO = ("goto-pickup-loc", ("mitchell", "r-5303"))
CLOSING = Closing(state=RequestState.CANCELED, reason="not needed", since=1.0)


def failing(trouble: Trouble, **fields: object) -> StepOutcome:
    return StepOutcome.model_validate(
        {"kind": "failed", "reason": "why", "trouble": trouble, **fields}
    )


def verdict(
    did: tuple[str, tuple[str, ...]],
    outcome: StepOutcome,
    *,
    request: DeliveryRequest | None = None,
    others: tuple[DeliveryRequest, ...] = (),
    times_before: int = 0,
    rooms: tuple[str, ...] = (),
    tray: frozenset[tuple[str, str]] = frozenset(),
    now: float = 1000.0,
) -> Verdict:
    request = request or make_request()
    case = Case(
        step=Step(9, *did, requests=(request.id,)),
        outcome=outcome,
        served=(request,),
        others=others,
        past={request.id: [PastStep(*did, outcome)] * times_before},
        rooms={request.id: rooms},
        facts=Facts(None, tray),
        now=now,
    )
    return judge(case, PATIENCE)


def hopeless(found: Verdict) -> list[str]:
    return [reason for _, reason in found.hopeless]


PASSING = [Trouble.NOBODY, Trouble.BLOCKED, Trouble.HINDERED, Trouble.UNSURE]


@pytest.mark.parametrize("trouble", PASSING)
@pytest.mark.parametrize(("times", "waits"), [(0, True), (1, True), (2, False)])
def test_what_time_may_cure_is_tried_again_a_bounded_number_of_times(trouble, times, waits):
    found = verdict(GOTO, failing(trouble), times_before=times)
    assert bool(found.holds) == waits
    assert hopeless(found) == ([] if waits else ["why, 3 times"])
    if waits:
        (hold,) = found.holds
        assert (hold.room, hold.until, hold.trouble) == ("r-5303", 1600.0, trouble)
        assert hold.reason == "why"
        assert hold.outlook == "why; trying again after " + show_time(1600.0)


def test_whoever_is_shut_in_waits_as_long_as_there_is_time():
    shut = failing(Trouble.SHUT_IN, room="r-5311")
    (hold,) = verdict(GOTO, shut, times_before=9).holds
    assert (hold.room, hold.trouble) == ("r-5311", Trouble.SHUT_IN)
    assert hopeless(verdict(GOTO, shut, now=4100.0)) == ["why"]


def test_nothing_is_put_off_beyond_its_deadline():
    found = verdict(ACQUIRE, failing(Trouble.NOBODY), now=4100.0)
    assert not found.holds
    assert hopeless(found) == ["why"]


def test_what_is_to_go_back_has_no_deadline_any_more():
    request = make_request(then="back", closing=CLOSING)
    silence = failing(Trouble.NOBODY)
    found = verdict(RETURN, silence, request=request, now=9999.0, tray=frozenset({MAIL}))
    assert found.holds


def test_others_that_need_the_room_next_are_put_off_with_it():
    other = make_request("b", item="pickupcoffee")
    assert [h.request for h in verdict(GOTO, failing(PASSING[0]), others=(other,)).holds] == [
        "a",
        "b",
    ]
    impossible = verdict(ACQUIRE, failing(Trouble.IMPOSSIBLE), others=(other,))
    assert not impossible.holds


@pytest.mark.parametrize(
    ("did", "tray", "moved"),
    [
        (ACQUIRE, frozenset(), {"pickup": "r-5305"}),
        (DELIVER, frozenset({MAIL}), {"deliver": "r-5305"}),
    ],
)
def test_where_somebody_says_impossible_another_room_of_the_user_is_tried(did, tray, moved):
    found = verdict(did, failing(Trouble.IMPOSSIBLE), rooms=("r-5313", "r-5305"), tray=tray)
    assert found.moved == [make_request(**moved)]
    assert not found.hopeless


def test_where_nobody_comes_in_another_room_is_tried_in_the_end():
    found = verdict(DELIVER, failing(Trouble.NOBODY), rooms=("r-5305",), times_before=2)
    assert [request.pickup for request in found.moved] == ["r-5305"]


def test_what_is_to_go_back_goes_to_no_other_room():
    request = make_request(then="back", closing=CLOSING)
    found = verdict(RETURN, failing(Trouble.IMPOSSIBLE), request=request, rooms=("r-5305",))
    assert hopeless(found) == ["why"]


def test_what_was_given_up_before_its_item_came_onto_the_tray_ends_as_was_decided():
    request = make_request(then="back", closing=CLOSING)
    assert verdict(ACQUIRE, failing(Trouble.NOBODY), request=request) == Verdict(closed=[request])


def test_a_delivery_that_fails_when_the_item_is_to_go_back_is_of_no_account():
    request = make_request(then="back", closing=CLOSING)
    tray = frozenset({MAIL})
    silence = failing(Trouble.NOBODY)
    assert verdict(DELIVER, silence, request=request, times_before=9, tray=tray) == Verdict()


def test_what_the_robot_is_unable_to_do_is_not_tried_elsewhere():
    found = verdict(DELIVER, failing(Trouble.UNABLE), rooms=("r-5305",))
    assert hopeless(found) == ["why"]


def test_a_step_that_nobody_wanted_has_no_consequences():
    assert verdict(GOTO, failing(Trouble.UNWANTED)) == Verdict()


def test_a_mistake_of_the_planner_is_corrected_and_not_held_against_the_errand_at_once():
    assert verdict(DELIVER, failing(Trouble.MISTAKEN)) == Verdict()
    assert hopeless(verdict(DELIVER, failing(Trouble.MISTAKEN), times_before=2)) == ["why, 3 times"]


def test_what_was_to_go_back_and_is_gone_is_over():
    request = make_request(then="back", closing=CLOSING)
    gone = failing(Trouble.MISTAKEN, gone=(MAIL,))
    assert hopeless(verdict(DELIVER, gone, request=request)) == ["why"]


def test_only_a_delivery_ends_what_was_done():
    done = StepOutcome(kind="done", room="r-5313")
    assert verdict(DELIVER, done).done == [make_request()]
    assert verdict(ACQUIRE, done) == Verdict()
