"""Killed at any moment of any scenario, the agent loses, repeats and asks nothing twice."""

from __future__ import annotations

from dataclasses import replace

import pytest
from rogue_crashes import Play, Run, cancel, post

from rogue.messages import RequestState
from rogue.planning import Rules

MAIL = post("a", "mitchell", "delivermail")
FAX = post("b", "jhm", "deliverfax", after=1, deliver="r-5313")

NOBODY_IN = frozenset(("placing", "r-5303", time) for time in range(9))

PLAYS = {
    "figure 6": Play((MAIL,), rules=Rules.NONE),
    "figure 9": Play((MAIL, FAX), rules=Rules.Y1996),
    "two errands": Play((MAIL, FAX)),
    "wrong arrivals": Play((MAIL,), misses={("r-5303", time): "r-5305" for time in range(2)}),
    "nobody in at all": Play((MAIL,), silent=NOBODY_IN),
    "a blocked door": Play((MAIL, FAX), blocked=frozenset({("r-5303", 0)})),
    "shut in": Play((MAIL,), shut_in=frozenset({("r-5313", 0)})),
    "impossible to deliver": Play((MAIL,), refused=frozenset({("taking", "r-5313", 0)})),
    "put off with a full tray": Play(
        (MAIL, replace(FAX, after_drives=2)),
        silent=frozenset({("taking", "r-5313", 0)}),
        places=1,
    ),
    "canceled under way": Play((MAIL, cancel("a", after=2))),
}

ENDS = {
    "nobody in at all": {RequestState.FAILED},
    "impossible to deliver": {RequestState.FAILED},
    "canceled under way": {RequestState.CANCELED},
}
"""How the requests of a play end, where they are not all completed."""


USERS = ("jblythe", "jgc", "khaigh", "pstone", "rich", "simmons", "skoenig", "veloso", "mitchell")
ROOMS = ("r-5301", "r-5303", "r-5305", "r-5307", "r-5309", "r-5311", "r-5313", "r-5315")

ERRANDS = [*((user, "pickupbook") for user in USERS), *((user, "recyclecan") for user in USERS[:6])]

MANY = Play(
    tuple(
        post(
            f"m{number}",
            user,
            item,
            after=number // 6,
            pickup=ROOMS[5 * number % 8],
            deliver=ROOMS[(5 * number + 3) % 8],
        )
        for number, (user, item) in enumerate(ERRANDS)
    ),
    places=3,
)
"""More errands than tours are exact for, and more than take part in one search."""


async def test_an_agent_that_is_killed_goes_on_in_the_order_in_which_it_would_have(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    first = Run(MANY)
    with monkeypatch.context() as patch:
        expected = await first.to_the_end(patch)
    assert {state for state, _ in expected.requests.values()} == {RequestState.COMPLETED}
    moments = {moment.world.drives: moment for moment in first.moments}
    assert len(moments) > len(ROOMS)
    for number in range(1, len(moments), 4):
        with monkeypatch.context() as patch:
            ending = await Run(MANY, begins=moments[number]).to_the_end(patch)
        assert ending.drives == expected.drives, f"killed after {number} drives"


@pytest.mark.parametrize("name", PLAYS)
async def test_a_kill_at_any_moment_changes_nothing(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = Run(PLAYS[name])
    with monkeypatch.context() as patch:
        expected = await first.to_the_end(patch)
    ends = {state for state, _ in expected.requests.values()}
    assert ends == ENDS.get(name, {RequestState.COMPLETED})
    for number, moment in enumerate(first.moments):
        with monkeypatch.context() as patch:
            ending = await Run(PLAYS[name], begins=moment).to_the_end(patch)
        when = f"killed at moment {number} of {len(first.moments)}"
        assert (ending.requests, ending.tray) == (expected.requests, expected.tray), when
        assert ending.acts <= expected.acts, when
