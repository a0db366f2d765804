"""What `rogue why` tells after whole runs of the office against a robot that answers at once."""

from __future__ import annotations

import pytest
from rogue_fakes import NO_ANSWER, failed, make_request, typed
from test_rogue_episode import FAX, Scene, scene

from rogue.messages import RequestState, WhyReport
from rogue.planning import Rules
from rogue.requests._why import why_report
from rogue.times import show_time

__all__ = ["scene"]


async def why(scene: Scene, name: str = "a", *, everything: bool = False) -> WhyReport:
    request = await scene.store.request(name)
    assert request is not None
    now, others = scene.clock.now(), scene.book.open_requests()
    return await why_report(scene.store, request, others, now, everything=everything)


def kinds(report: WhyReport) -> list[str]:
    return [entry.kind for entry in report.entries]


def said(report: WhyReport, kind: str) -> list[str]:
    return [entry.sentence for entry in report.entries if entry.kind == kind]


@pytest.fixture
async def shared_way(scene: Scene) -> Scene:
    """An urgent errand to the same room comes while the robot drives for the first."""
    late = make_request("b", **FAX)
    scene.robot.events[0] = lambda: scene.book.add(late, None)
    await scene.play(Rules.WORKING, make_request(posted=999.0))
    return scene


async def test_who_was_overtaken_is_told_by_whom_and_by_which_rule(shared_way: Scene):
    report = await why(shared_way)
    [overtaken] = said(report, "overtaken")
    assert overtaken == (
        "It was overtaken by request b (rank 8), which came later: driving to r-5311 to fetch "
        "something for jhm came first, since it is the next stop of the best round through all "
        "rooms."
    )
    [entry] = [one for one in report.entries if one.kind == "overtaken"]
    assert entry.rule == "order-of-tour"
    assert entry.over == ("<goto-deliver-loc mitchell r-5313>",)
    assert entry.time == shared_way.clock.now()


async def test_errands_that_share_a_drive_say_so(shared_way: Scene):
    assert said(await why(shared_way), "merged") == [
        "It shares the drive to r-5313 with request b (rank 8)."
    ]
    assert said(await why(shared_way, "b"), "merged") == [
        "It shares the drive to r-5313 with request a (rank 5)."
    ]


async def test_each_step_is_told_with_its_reason_and_then_its_end(shared_way: Scene):
    told = [kind for kind in kinds(await why(shared_way)) if kind in {"step", "done"}]
    assert told == ["step", "done"] * 4
    assert kinds(await why(shared_way))[-1] == "ended"
    long = await why(shared_way, everything=True)
    assert {"goal", "operator", "bindings"} <= set(kinds(long))


async def test_a_closed_door_is_told_until_when_and_in_the_end_why(scene: Scene):
    scene.robot.drives = [failed("door_blocked")] * 9
    await scene.play(Rules.WORKING, make_request())
    report = await why(scene)
    told = [k for k in kinds(report) if k in {"planned", "failed", "postponed", "ended"}]
    assert told == [*["planned", "failed", "postponed"] * 2, "planned", "failed", "ended"]
    assert said(report, "planned")[1:] == ["The planner took it up again."] * 2
    first = said(report, "postponed")[0]
    until = show_time(1600.0)
    assert first == f"It was put off until {until}: cannot get to r-5303, it was door_blocked."
    assert report.entries[-1].sentence.endswith(", 3 times.")


async def test_while_it_is_put_off_that_is_how_it_stands(scene: Scene):
    scene.robot.drives = [failed("door_blocked")] * 9
    await scene.book.add(make_request(), None)
    await scene.episode(Rules.WORKING).run()
    now = (await why(scene)).entries[-1]
    assert (now.kind, now.time) == ("now", None)
    assert now.sentence.startswith(f"It waits until {show_time(1600.0)}: cannot get to")


async def test_that_nobody_answered_is_told(scene: Scene):
    scene.robot.answers = [typed("y"), *[NO_ANSWER] * 30]
    await scene.play(Rules.WORKING, make_request())
    report = await why(scene)
    assert said(report, "failed")[0] == (
        "Having delivermail for mitchell put on the tray in r-5303 did not succeed: acquire-item "
        "at r-5303, nobody answered within 60 s."
    )
    assert report.entries[-1].sentence.startswith("It failed: acquire-item at r-5303, nobody")


async def test_a_cancellation_ends_the_story(scene: Scene):
    await scene.book.add(make_request(), None)
    await scene.book.give_up("a", RequestState.CANCELED, "not needed")
    report = await why(scene)
    assert kinds(report) == ["posted", "ended"]
    assert report.sentences[-1].endswith("It is canceled: not needed.")


async def test_a_deadline_that_passed_ends_the_story(scene: Scene):
    await scene.book.add(make_request(), None)
    reason = "its deadline, Mar 4 14:30, passed before it was done"
    await scene.book.give_up("a", RequestState.FAILED, reason)
    assert (await why(scene)).sentences[-1].endswith(f"It failed: {reason}.")
