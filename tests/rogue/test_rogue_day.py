"""The script of a day, and the judgement of what came of it."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rogue.cli._day import staff
from rogue.messages import DeliveryRequest, RequestState
from rogue.requests import load_directory
from rogue.scenarios import (
    DayPlan,
    DayRecord,
    Handover,
    Kind,
    Post,
    Verified,
    counts,
    differences,
    faults,
    make_day,
    verification,
)

ROOMS = [f"r-53{n:02d}" for n in range(1, 33)] + [f"r-54{n:02d}" for n in range(1, 29)]
STAFF = staff(load_directory())


def script(seed: int = 1, requests: int = 60) -> DayPlan:
    return make_day(STAFF, users=10, requests=requests, hours=2.0, seed=seed, rooms=ROOMS)


def ended(post: Post, state: RequestState, reason: str | None = None, at: float = 1e9):
    return DeliveryRequest(
        id=post.id,
        user=post.user,
        item=post.item,
        pickup=post.pickup,
        deliver=post.deliver,
        state=state,
        rank=1,
        posted=post.at,
        deadline=post.at + post.deadline,
        finished=at,
        reason=reason,
    )


def good_record(plan: DayPlan) -> DayRecord:
    """A day on which everything went as it should."""
    record = DayRecord()
    for post in plan.posts:
        match post.kind:
            case Kind.MISNAMED:
                record.refused[post.id] = ("unknown_room", "there is no room r-9999")
            case Kind.HURRIED:
                record.refused[post.id] = ("too_late", "not before 10:00")
            case Kind.UNREACHABLE:
                record.ended[post.id] = ended(post, RequestState.FAILED, "door_blocked")
            case Kind.CANCELED:
                record.ended[post.id] = ended(post, RequestState.CANCELED, "canceled by its user")
            case _:
                record.ended[post.id] = ended(post, RequestState.COMPLETED)
                record.handovers += handed_over(post)
    return record


def handed_over(post: Post) -> list[Handover]:
    return [
        Handover(0.0, "placed", post.user, post.item, post.pickup),
        Handover(0.0, "taken", post.user, post.item, post.deliver),
    ]


def first(plan: DayPlan, kind: Kind) -> Post:
    """The first request of a kind that meets nobody who is silent."""
    return next(
        post
        for post in plan.posts
        if post.kind is kind and not {post.pickup, post.deliver} & plan.silent
    )


@settings(max_examples=25)
@given(st.integers(0, 10_000))
def test_a_script_is_whole_and_made_by_its_seed(seed: int):
    plan = script(seed)
    assert plan == script(seed)
    assert len(plan.posts) == 60
    assert len({(post.user, post.item) for post in plan.posts}) == 60
    assert len({post.user for post in plan.posts}) == 10
    kinds = Counter(post.kind for post in plan.posts)
    assert all(kinds[kind] for kind in Kind)
    times = [at for at, _ in plan.events()]
    assert times == sorted(times)
    assert all(post.pickup != post.deliver for post in plan.posts)
    assert all(plan.taken_back(post.id) for post in plan.posts if post.kind is Kind.CANCELED)
    assert len(plan.silent) == 2
    used = {room for post in plan.posts for room in (post.pickup, post.deliver)}
    unreachable = [post for post in plan.posts if post.kind is Kind.UNREACHABLE]
    assert used & plan.shut == {r for p in unreachable for r in (p.pickup, p.deliver)} & plan.shut


def test_a_good_day_has_no_faults():
    plan = script()
    record = good_record(plan)
    assert faults(plan, record) == []
    assert differences(plan, record, record) == []
    assert sum(counts(plan, record)[Kind.HURRIED].values()) == 2


@pytest.mark.parametrize(
    ("kind", "state"),
    [
        (Kind.ORDINARY, RequestState.FAILED),
        (Kind.ORDINARY, RequestState.CANCELED),
        (Kind.ORDINARY, RequestState.UNDERWAY),
        (Kind.UNREACHABLE, RequestState.COMPLETED),
        (Kind.CANCELED, RequestState.COMPLETED),
    ],
)
def test_an_end_that_does_not_fit_is_a_fault(kind: Kind, state: RequestState):
    plan, record = script(), good_record(script())
    post = first(plan, kind)
    record.ended[post.id] = ended(post, state, "for some reason")
    found = faults(plan, record)
    assert any(fault.startswith(f"{post.id} ({kind}) is {state}") for fault in found)


def test_what_was_done_before_it_was_taken_back_may_be_completed():
    plan, record = script(), good_record(script())
    timed = [one for one in plan.back if one.at is not None]
    posts = {post.id: post for post in plan.posts}
    back = next(
        one for one in timed if not {posts[one.id].pickup, posts[one.id].deliver} & plan.silent
    )
    post = posts[back.id]
    assert back.at is not None
    record.ended[post.id] = ended(post, RequestState.COMPLETED, at=back.at - 1.0)
    record.handovers += handed_over(post)
    assert faults(plan, record) == []


def test_what_is_taken_back_from_the_tray_is_never_completed():
    plan, record = script(), good_record(script())
    posts = {post.id: post for post in plan.posts}
    late = [posts[one.id] for one in plan.back if one.at is None]
    post = next(post for post in late if not {post.pickup, post.deliver} & plan.silent)
    assert plan.taken_from_tray(post.user, post.item) == plan.taken_back(post.id)
    record.ended[post.id] = ended(post, RequestState.COMPLETED, at=0.0)
    assert any("expected canceled" in fault for fault in faults(plan, record))


def test_an_item_in_wrong_hands_is_a_fault():
    plan, record = script(), good_record(script())
    post = first(plan, Kind.ORDINARY)
    at = next(i for i, one in enumerate(record.handovers) if one.room == post.deliver)
    record.handovers[at] = replace(record.handovers[at], room="r-5432")
    assert any("r-5432" in fault for fault in faults(plan, record))


def test_an_item_handed_over_twice_is_a_fault():
    plan, record = script(), good_record(script())
    post = first(plan, Kind.ORDINARY)
    record.handovers += handed_over(post)
    assert any(fault.startswith(f"{post.id}: the item was") for fault in faults(plan, record))


def test_an_item_that_stays_on_the_tray_must_be_told():
    plan, record = script(), good_record(script())
    post = first(plan, Kind.CANCELED)
    record.handovers.append(handed_over(post)[0])
    assert any("left on the tray" in fault for fault in faults(plan, record))
    told = ended(post, RequestState.CANCELED, "canceled; it is still on the tray")
    record.ended[post.id] = told
    assert faults(plan, record) == []


def test_an_end_without_a_reason_is_a_fault():
    plan, record = script(), good_record(script())
    post = first(plan, Kind.UNREACHABLE)
    record.ended[post.id] = ended(post, RequestState.FAILED)
    assert f"{post.id} is failed without a reason" in faults(plan, record)


def test_two_runs_are_compared_request_by_request():
    plan, one, other = script(), good_record(script()), good_record(script())
    post = first(plan, Kind.ORDINARY)
    other.ended[post.id] = ended(post, RequestState.FAILED, "nobody answered")
    (difference,) = differences(plan, one, other)
    assert difference == f"{post.id} (ordinary): completed, and then failed (nobody answered)"


def test_arrivals_are_counted_by_the_layer_that_made_sure():
    arrivals = [
        Verified("r-5303", "r-5303", "belief"),
        Verified("r-5303", "r-5305", "camera"),
        Verified("r-5303", None, None),
        Verified("r-5313", "r-5313", "person"),
    ]
    assert verification(DayRecord(arrivals=arrivals)) == {
        "belief": 1,
        "camera": 1,
        "person": 1,
        "unsure": 1,
        "elsewhere": 1,
    }
