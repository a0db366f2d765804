from __future__ import annotations

import pytest

from rogue.errors import DeadlineError, DuplicateError, SameRoomError, UnknownNameError
from rogue.messages import DeliveryRequest, Filled, PostRequest, RequestState
from rogue.requests import (
    PlanFile,
    accept,
    draft,
    is_same_errand,
    load_directory,
    refuse_duplicate,
)

ROOMS = [f"r-53{number:02d}" for number in range(1, 16)]
NOW = 1_000_000.0
Taken = tuple[DeliveryRequest, tuple[Filled, ...]]


def take(**fields: str | None) -> DeliveryRequest:
    return taken(**fields)[0]


def taken(plan: PlanFile | None = None, **fields: str | None) -> Taken:
    message = PostRequest(**{"id": "a", "user": "mitchell", "item": "delivermail", **fields})
    directory = load_directory()
    rooms = draft(message, directory=directory, plan=plan, rooms=ROOMS)
    return accept(message, rooms, directory=directory, plan=plan, now=NOW)


def test_what_is_missing_is_filled_in():
    request = take()
    assert (request.pickup, request.deliver, request.rank) == ("r-5303", "r-5313", 5)
    assert (request.posted, request.deadline) == (NOW, NOW + 3600)
    assert request.state is RequestState.QUEUED


def test_what_is_named_counts():
    request = take(pickup="R-5301", deliver="5305", deadline="+10m")
    assert (request.pickup, request.deliver) == ("r-5301", "r-5305")
    assert request.deadline == NOW + 600


def test_names_are_taken_in_any_case():
    assert take(user="Mitchell", item="DeliverMail").user == "mitchell"


def test_an_unknown_room_names_near_ones():
    with pytest.raises(UnknownNameError, match=r"'r-5399'.* Did you mean 'r-53") as caught:
        take(pickup="r-5399")
    assert caught.value.objection.field == "pickup"
    assert caught.value.objection.value == "r-5399"
    assert "r-53" in caught.value.objection.expected


def test_pickup_must_not_be_delivery():
    with pytest.raises(SameRoomError, match="both r-5313"):
        take(pickup="r-5313")


def test_a_deadline_that_has_passed_is_refused():
    with pytest.raises(DeadlineError):
        take(deadline="0m")


def test_the_same_errand_is_recognised_whatever_was_filled_in():
    known = take()
    again = PostRequest(id="a", user="mitchell", item="delivermail", deliver="R-5313")
    other = PostRequest(id="a", user="mitchell", item="delivermail", deliver="r-5301")
    assert is_same_errand(again, known)
    assert not is_same_errand(other, known)


def test_what_was_filled_in_is_kept_with_its_source():
    _, filled = taken(pickup="5301")
    assert [(one.slot, one.value, one.source) for one in filled] == [
        ("deliver", "r-5313", "directory"),
        ("deadline", "1h", "default"),
    ]


def test_what_users_name_themselves_is_not_filled_in():
    _, filled = taken(pickup="5301", deliver="5305", deadline="10m")
    assert filled == ()


def test_a_plan_file_comes_after_the_directory_and_before_the_defaults():
    plan = PlanFile(room="5301", deadline="20m", ends={("deliver", "delivermail"): "5307"})
    request, filled = taken(plan=plan)
    assert (request.deliver, request.deadline) == ("r-5313", NOW + 1200)
    assert [(one.slot, one.source) for one in filled] == [
        ("pickup", "directory"),
        ("deliver", "directory"),
        ("deadline", "finger"),
    ]


def test_a_deadline_of_a_plan_file_that_cannot_be_read_does_not_count():
    request, filled = taken(plan=PlanFile(deadline="never"))
    assert (request.deadline, filled[-1].source) == (NOW + 3600, "default")


def test_the_same_errand_under_another_id_is_a_duplicate():
    known = take()
    with pytest.raises(DuplicateError, match="open already, as request 'a'") as caught:
        refuse_duplicate(take(id="b"), [known])
    assert caught.value.objection.other == "a"
    refuse_duplicate(take(id="b", deliver="5301"), [known])
    refuse_duplicate(take(id="b", user="jhm", deliver="5313"), [known])
