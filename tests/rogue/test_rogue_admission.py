"""Which requests take part in the search."""

from __future__ import annotations

from rogue_fakes import make_request

from rogue.admission import MOST, MOST_ALONG, choose, servable
from rogue.messages import DeliveryRequest


def chosen(
    requests: list[DeliveryRequest],
    *,
    begun: tuple[str, ...] = (),
    pinned: tuple[str, ...] = (),
    most: int = MOST,
) -> list[str]:
    found = choose(
        requests,
        begun=begun,
        pinned=pinned,
        priority=lambda request: float(request.rank),
        identity=lambda request: (request.user, request.item),
        most=most,
    )
    return [request.id for request in found]


def request(number: int, rank: int, **fields: object) -> DeliveryRequest:
    own = {"user": f"user{number}", "pickup": f"r-{100 + number}", "deliver": f"r-{200 + number}"}
    return make_request(f"q{number}", rank=rank, **{**own, **fields})


def test_the_most_urgent_take_part():
    many = [request(number, number % 30) for number in range(100)]
    ranks = [next(r.rank for r in many if r.id == name) for name in chosen(many)]
    assert len(ranks) == MOST
    assert ranks == sorted(ranks, reverse=True)
    assert min(ranks) >= 29 - MOST // 3


def test_of_equals_the_earlier_deadline_and_then_the_older_comes_first():
    requests = [request(1, 0, deadline=3000.0), request(2, 0, deadline=2000.0)]
    requests.append(request(3, 0, deadline=2000.0))
    assert chosen(requests) == ["q2", "q3", "q1"]


def test_what_was_begun_stays_unless_another_is_clearly_more_urgent():
    requests = [request(1, 3), request(2, 4)]
    assert chosen(requests, begun=("q1",), most=1) == ["q1"]
    requests = [request(1, 3), request(2, 5)]
    assert chosen(requests, begun=("q1",), most=1) == ["q2"]


def test_what_is_on_the_tray_stays():
    requests = [request(number, number) for number in range(1, 5)]
    assert chosen(requests, pinned=("q1", "q2", "q3"), most=2) == ["q3", "q2", "q1"]


def test_what_begins_and_ends_where_others_do_comes_along():
    first = request(1, 9)
    along = [
        request(number, 0, pickup=first.pickup, deliver=first.deliver) for number in range(2, 20)
    ]
    elsewhere = request(30, 0)
    assert chosen([first, elsewhere, *along], most=1) == [
        "q1",
        *(f"q{number}" for number in range(2, 2 + MOST_ALONG)),
    ]


def test_of_two_that_cannot_be_told_apart_one_waits():
    one, other = request(1, 0, user="ann"), request(2, 9, user="ann")
    assert chosen([one, other]) == ["q1"]
    assert chosen([one, other], begun=("q2",)) == ["q2"]


def gone_on_with(
    *, waiting: tuple[str, ...], tray: tuple[str, ...], places: int | None
) -> list[str]:
    requests = [request(number, 0) for number in range(1, 4)]
    things = [(r.user, r.item) for r in requests if r.id in tray]
    things += [(name, "delivermail") for name in tray if not name.startswith("q")]
    found = servable(requests, waits=lambda r: r.id in waiting, tray=things, places=places)
    return [r.id for r in found]


def test_what_is_put_off_waits():
    assert gone_on_with(waiting=("q1",), tray=(), places=1) == ["q2", "q3"]


def test_where_what_is_put_off_fills_the_tray_the_others_wait_for_a_place():
    assert gone_on_with(waiting=("q1",), tray=("q1",), places=1) == []
    assert gone_on_with(waiting=("q1",), tray=("q1",), places=2) == ["q2", "q3"]
    assert gone_on_with(waiting=("q1",), tray=("q1",), places=None) == ["q2", "q3"]


def test_what_is_on_the_tray_itself_goes_on_and_gives_its_place_to_others():
    assert gone_on_with(waiting=("q1",), tray=("q1", "q2"), places=2) == ["q2", "q3"]
    assert gone_on_with(waiting=("q1",), tray=("q1", "somebody"), places=2) == []


def test_a_tray_that_nobody_is_going_to_empty_is_left_to_the_planner_to_refuse():
    assert gone_on_with(waiting=(), tray=("somebody",), places=1) == ["q1", "q2", "q3"]
    assert gone_on_with(waiting=("q1",), tray=("somebody",), places=1) == ["q2", "q3"]
