"""The tray: its places, and what has to leave it."""

from __future__ import annotations

import pytest
from errands_play import Changed, Play

from rogue.errands import MOST_PLACES, Errand, TrayError, tray_counts, tray_state
from rogue.prodigy import Literal

ROOMS = [f"r-53{n:02d}" for n in range(1, 24, 2)]
THINGS = [("mitchell", "delivermail"), ("jhm", "deliverfax"), ("newell", "parcel")]
THREE = [Errand(*thing, ROOMS[1 + n], ROOMS[6 + n]) for n, thing in enumerate(THINGS)]


def most_carried(steps: list[str]) -> int:
    held, most = 0, 0
    for step in steps:
        held += step.startswith("acquire") - step.startswith(("deliver", "return"))
        most = max(most, held)
    return most


@pytest.mark.parametrize(("places", "most"), [(None, 3), (3, 3), (2, 2), (1, 1)])
def test_the_plan_never_asks_more_of_the_tray_than_it_holds(places: int | None, most: int):
    play = Play(places=places)
    play.begin(THREE, ROOMS)
    done = play.run()
    assert most_carried(done) == most
    assert sum(step.startswith("deliver-item") for step in done) == 3
    assert len(play.search.nodes()) <= 4 + 16 * 3 + 6


def test_room_is_made_for_an_urgent_errand_on_a_full_tray():
    play = Play(places=1, nearby=0.0)
    low = play.claim(Errand("mitchell", "delivermail", "r-5303", "r-5321"), 0.0)
    high = play.claim(Errand("jhm", "deliverfax", "r-5301", "r-5303"), 9.0)
    play.at_step[2] = lambda: play.arrive(high)
    play.begin([low], ROOMS)
    done = play.run()
    assert done[-1] == "deliver-item r-5303 jhm deliverfax"
    assert most_carried(done) == 1


def test_what_waits_on_the_tray_for_somebody_takes_its_place():
    """The parcel is nobody's goal for now: with one place left, each thing goes as it is taken."""
    fetched = [
        Errand(user, item, ROOMS[1 + n], ROOMS[2 + n])
        for n, (user, item) in enumerate(
            (user, item) for user in ("mitchell", "jhm") for item in ("delivermail", "parcel")
        )
    ]
    play = Play(places=2)
    fax = Errand("jhm", "deliverfax", "r-5301", "r-5321")
    play.begin([fax, *fetched], ROOMS, carried=[("newell", "parcel")])
    done = play.run()
    assert most_carried(done) == 1
    then = [done[n + 1].split()[0] for n, step in enumerate(done) if step.startswith("acquire")]
    assert then == ["goto-deliver-loc"] * 5


def test_an_item_whose_errand_is_given_up_goes_back():
    play = Play()
    mail = Errand("mitchell", "delivermail", "r-5303", "r-5321")
    back = Errand("mitchell", "delivermail", "r-5303", "r-5303", back=True)

    def give_up() -> Changed:
        play.withdraw(mail)
        play.arrive(back)
        return None

    play.at_step[3] = give_up
    play.begin([mail], ROOMS)
    assert play.run()[-2:] == [
        "goto-deliver-loc mitchell r-5303",
        "return-item r-5303 mitchell delivermail",
    ]


def test_an_item_that_left_the_tray_cannot_be_brought_back():
    play = Play()
    back = Errand("mitchell", "delivermail", "r-5303", "r-5303", back=True)
    play.begin([back], ROOMS)
    for _ in play.search.events():
        pass
    assert play.search.result is not None
    assert play.search.executed_operators() == ()
    assert play.search.result.status != "solved"


def test_what_is_true_of_a_tray():
    assert tray_counts(2) == ("none", "one", "two")
    assert list(tray_state(2, 1)) == [Literal("places-left", ("one",))]
    assert Literal("tray-full") in tray_state(2, 2)
    assert list(tray_state(None, 9)) == []


@pytest.mark.parametrize("places", [0, MOST_PLACES + 1])
def test_a_tray_that_cannot_be_counted_is_refused(places: int):
    with pytest.raises(TrayError, match=f"a tray of {places} places; expected 1 to {MOST_PLACES}"):
        tray_counts(places)
