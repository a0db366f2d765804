from __future__ import annotations

import pytest

from rogue.errors import DeadlineError, SameRoomError, UnknownNameError
from rogue.messages import DeliveryRequest, PostRequest, RequestState
from rogue.requests import accept, is_same_errand, load_directory

ROOMS = [f"r-53{number:02d}" for number in range(1, 16)]
NOW = 1_000_000.0


def take(**fields: str | None) -> DeliveryRequest:
    message = PostRequest(**{"id": "a", "user": "mitchell", "item": "delivermail", **fields})
    return accept(message, directory=load_directory(), rooms=ROOMS, now=NOW)


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
    with pytest.raises(UnknownNameError, match=r"'r-5399'.* Did you mean 'r-53"):
        take(pickup="r-5399")


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
